"""The robot's own arm, told from the objects on the table."""
