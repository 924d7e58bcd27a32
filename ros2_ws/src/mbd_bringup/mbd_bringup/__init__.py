"""Launch files, parameters and the demo."""
