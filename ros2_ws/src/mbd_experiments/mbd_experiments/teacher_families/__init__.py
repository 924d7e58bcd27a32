"""Simulated teachers of many kinds, and how well each strategy serves them."""
