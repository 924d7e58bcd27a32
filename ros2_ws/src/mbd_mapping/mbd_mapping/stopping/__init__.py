"""When the robot goes on alone so that a promised share of sessions is right."""
