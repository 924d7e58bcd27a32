"""Recordings of other layouts, and pictures of them."""
