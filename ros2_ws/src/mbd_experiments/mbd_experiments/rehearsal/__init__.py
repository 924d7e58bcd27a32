"""A study's rehearsal: its plan held by simulated people, operator's slips and forms included, up to the figures."""
