"""RGB-D frames to the objects on a table and their features."""
