"""What the stamps of a recording tell, and what is wrong with them."""
