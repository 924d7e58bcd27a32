"""The paper's user study as session bags, and its experiments 2 and 3 (sec. 6, 7)."""
