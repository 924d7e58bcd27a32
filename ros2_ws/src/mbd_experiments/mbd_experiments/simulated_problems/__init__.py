"""Experiment 1 and the case studies (paper sec. 5)."""
