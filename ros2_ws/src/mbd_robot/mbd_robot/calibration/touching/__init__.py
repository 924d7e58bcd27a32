"""A board on the table whose corners the tool touched, before a camera that stands."""
