"""The recorder's threads, its clock, and which images it keeps."""
