"""What of the console outlives it."""
