"""Where the tool must be to grasp an object: as it was shown, and in every other way that its shape allows."""
