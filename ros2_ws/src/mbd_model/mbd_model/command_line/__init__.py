"""What every command line of this project has in common: its parser, and the numbers and places that it takes."""
