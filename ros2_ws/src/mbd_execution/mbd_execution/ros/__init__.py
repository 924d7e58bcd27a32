"""The execution node and its client of the arm's actions."""
