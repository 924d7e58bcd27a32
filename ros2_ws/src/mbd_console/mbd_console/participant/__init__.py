"""The page of the participant."""
