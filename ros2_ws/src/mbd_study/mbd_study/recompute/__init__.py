"""Recorded sessions computed again, and compared with what was recorded."""
