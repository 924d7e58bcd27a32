"""Where points of the robot's frame appear in a camera's picture: perception's own camera, seen the other way."""

from __future__ import annotations

from mbd_perception.projection import CameraView, Points

__all__ = ["CameraView", "Points"]
