"""The printed board: made, found in a picture, and where it is before the camera."""
