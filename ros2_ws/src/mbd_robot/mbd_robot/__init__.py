"""Arms, hands and cameras as their drivers speak, behind the suite's one set of topics and actions."""
