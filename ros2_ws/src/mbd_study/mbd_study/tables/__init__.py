"""Sessions as tables."""
