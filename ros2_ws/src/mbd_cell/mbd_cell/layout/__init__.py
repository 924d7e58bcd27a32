"""Which objects there are, their shapes, and where they stand."""
