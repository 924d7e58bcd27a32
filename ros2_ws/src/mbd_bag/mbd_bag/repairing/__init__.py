"""A copy of a damaged bag with all that is intact in it, and how much that is."""
