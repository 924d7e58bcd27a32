"""A camera as everybody speaks of it: its lens, where it stands, what it sees."""
