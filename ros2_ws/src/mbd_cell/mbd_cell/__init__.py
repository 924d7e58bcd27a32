"""A simulated Jaco2 tabletop cell: arm, gripper, RGB-D camera, objects, scripted teacher and wizard."""
