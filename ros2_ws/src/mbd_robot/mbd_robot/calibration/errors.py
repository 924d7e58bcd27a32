"""What cannot be calibrated."""

from __future__ import annotations

from mbd_model.errors import MbdError


class CalibrationError(MbdError):
    """Pictures, poses or a board from which the camera's pose cannot be known."""


class AlikePosesError(CalibrationError):
    """The tool was turned too little, or about one axis only: part of the camera's pose is left open."""
