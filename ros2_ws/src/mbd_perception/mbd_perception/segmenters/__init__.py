"""From a frame to labels: one narrow interface, our own segmenter behind it, and how another one is plugged in."""
