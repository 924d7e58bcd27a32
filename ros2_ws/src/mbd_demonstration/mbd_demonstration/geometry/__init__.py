"""What holds what up, and which closings and openings are no steps."""
