"""Pictures for a calibration, off the running robot and camera."""
