"""Which pieces of the picture are one object."""
