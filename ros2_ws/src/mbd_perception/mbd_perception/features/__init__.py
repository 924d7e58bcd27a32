"""The pixels of an object to its features."""
