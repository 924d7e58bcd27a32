"""The operator's and the participant's web pages."""
