"""Which surface objects stand on, and how far it reaches."""
