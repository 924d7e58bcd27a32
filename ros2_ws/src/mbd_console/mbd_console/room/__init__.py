"""Sound and picture of the room, from the operator's browser to files beside the bag."""
