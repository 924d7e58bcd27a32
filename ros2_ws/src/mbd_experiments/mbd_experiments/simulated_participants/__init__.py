"""Simulated participants: whole sessions of the user study in the simulated cell, in process."""
