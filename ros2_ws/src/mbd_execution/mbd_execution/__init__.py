"""The rest of the demonstrated task, executed on the target objects."""
