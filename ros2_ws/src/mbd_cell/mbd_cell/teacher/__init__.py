"""The scripted teacher and the scripted wizard."""
