"""Copies of sessions that may be given away: without what shows or names a person."""
