"""A study's plan: who does what in which order, which session is next, and where the plan was left."""
