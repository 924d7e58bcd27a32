"""What happens to a session's processes on purpose, and whether the session survives it."""
