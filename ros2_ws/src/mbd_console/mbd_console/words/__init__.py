"""What the pages say, in several languages: one table of texts, objects in lay words, the robot's sentences."""
