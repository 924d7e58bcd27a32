"""Complete tasks executed in the simulated cell, counted."""
