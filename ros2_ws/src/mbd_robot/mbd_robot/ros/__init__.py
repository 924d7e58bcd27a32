"""The robot node and the camera node."""
