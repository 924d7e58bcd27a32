"""Sessions to whose nodes faults happen."""
