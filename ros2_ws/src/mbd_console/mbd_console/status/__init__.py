"""Whether all is well: connected, recorded, seen, and with room on the disk."""
