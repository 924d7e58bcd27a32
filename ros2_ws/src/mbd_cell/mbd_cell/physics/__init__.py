"""The MuJoCo model, its simulation and its camera."""
