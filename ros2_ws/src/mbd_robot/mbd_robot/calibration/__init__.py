"""The camera's pose by pictures of a printed board, how exactly it is known, and whether it still holds."""
