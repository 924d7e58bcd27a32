"""Generated demonstrations: what teachers do with a hand, and what robots, clocks and people make of it."""
