"""Sound and picture of the room: what is kept beside a film of it, and the test signal in it."""
