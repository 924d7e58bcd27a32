"""Rendered frames with known truth, and scores against a truth."""
