"""The driver's own stops: heard, and called with the suite's."""
