"""Where RGB-D frames come from: images, clouds, files."""
