"""Messages of the shared values, quality of service, latched topics, parameters, the life of a node."""
