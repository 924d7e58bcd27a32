"""The mapping node."""
