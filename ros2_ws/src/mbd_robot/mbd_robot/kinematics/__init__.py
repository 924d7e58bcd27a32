"""The arm as a chain of joints: where the tool is, and which joint angles put it somewhere."""
