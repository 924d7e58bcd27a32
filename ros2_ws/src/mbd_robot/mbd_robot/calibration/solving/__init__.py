"""From pairs to the camera's pose: closed forms, refinement, noise, wrong pairs, what is left in doubt."""
