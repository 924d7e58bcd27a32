"""The work under way as a value, what can go wrong with it, and what a look at the table makes of it."""
