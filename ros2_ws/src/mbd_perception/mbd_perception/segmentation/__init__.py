"""A frame to the table and the pixels of each object on it."""
