"""Sessions as pictures and pages."""
