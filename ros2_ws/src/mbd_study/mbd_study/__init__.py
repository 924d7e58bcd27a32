"""What a recorded session says: recomputed, as tables and as figures."""
