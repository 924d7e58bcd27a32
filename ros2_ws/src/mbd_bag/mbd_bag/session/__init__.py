"""What a bag says of a session."""
