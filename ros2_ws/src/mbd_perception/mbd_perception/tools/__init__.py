"""Commands: segment frames from files, with pictures of every stage."""
