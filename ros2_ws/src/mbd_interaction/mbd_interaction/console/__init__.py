"""The wizard's console: a web page for the operator, and one for the participant to look at."""
