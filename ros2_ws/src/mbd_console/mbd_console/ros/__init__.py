"""The console's node and its start."""
