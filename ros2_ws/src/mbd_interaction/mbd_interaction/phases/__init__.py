"""The phases of a session: what each event does in each, and what the robot asks."""
