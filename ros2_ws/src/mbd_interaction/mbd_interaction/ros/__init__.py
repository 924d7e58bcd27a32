"""The interaction node."""
