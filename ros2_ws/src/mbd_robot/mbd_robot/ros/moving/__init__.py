"""Arm and hand told to move, each in its driver's words, and how that ended."""
