"""What a recorded session states: recomputed, as tables and as figures."""
