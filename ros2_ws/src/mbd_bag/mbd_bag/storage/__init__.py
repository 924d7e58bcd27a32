"""Bags on disk: MCAP files, their metadata, how they are written, read, upgraded and completed."""
