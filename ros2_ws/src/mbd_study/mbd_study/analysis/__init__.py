"""What a study's tables show: means, tests, effect sizes, and what so few participants can show at all."""
