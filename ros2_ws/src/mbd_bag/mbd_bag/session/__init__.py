"""What a bag states of a session."""
