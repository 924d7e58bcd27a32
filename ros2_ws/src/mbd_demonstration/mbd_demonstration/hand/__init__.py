"""What the fingers show: several as one, filtered, where they turn."""
