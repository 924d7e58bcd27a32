"""Carrying on alone: the rest of the demonstrated task, done on the target objects."""
