"""Tool trajectory and gripper events to pick and place steps with their primary objects."""
