"""Simulated participants: complete sessions of the user study in the simulated cell, in process."""
