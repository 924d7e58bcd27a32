"""Scenes, steps and assists to an object mapping with a confidence."""
