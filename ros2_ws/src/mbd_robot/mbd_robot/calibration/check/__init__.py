"""Whether a camera's pose holds: drawn into its picture, and in millimetres."""
