"""The simulated cell's messages as values."""
