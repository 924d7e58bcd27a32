"""Pictures of the board with the tool poses they were taken at: read from wherever they were kept."""
