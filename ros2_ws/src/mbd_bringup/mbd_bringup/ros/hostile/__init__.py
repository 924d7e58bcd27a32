"""Messages that make no sense, sent to every node of a session."""
