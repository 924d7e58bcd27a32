"""What of a bag is played again, and when."""
