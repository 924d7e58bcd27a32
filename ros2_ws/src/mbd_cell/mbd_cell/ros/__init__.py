"""The cell's node, its actions, and the scripted wizard's node."""
