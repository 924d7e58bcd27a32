"""What a driver speaks, as typed values read from YAML."""
