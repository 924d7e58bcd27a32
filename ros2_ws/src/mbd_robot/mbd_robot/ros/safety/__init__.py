"""The driver's own stops: received, and called with the suite's."""
