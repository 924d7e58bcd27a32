"""Where objects are, in extents rather than centroids: their boxes, and what lies left of or beyond what."""
