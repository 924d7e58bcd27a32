"""Best, second-best and tied assignments, and sums over all of them."""
