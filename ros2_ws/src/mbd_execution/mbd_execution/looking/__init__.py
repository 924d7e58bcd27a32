"""Looking at the table again: which object seen is which of those believed there, and what has changed."""
