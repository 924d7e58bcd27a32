"""A session of the simulated cell as a film."""
