"""How a film of the room stands to its session's bag."""
