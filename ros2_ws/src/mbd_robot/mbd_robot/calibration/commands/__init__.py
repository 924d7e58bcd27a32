"""What `calibrate` does, a module each."""
