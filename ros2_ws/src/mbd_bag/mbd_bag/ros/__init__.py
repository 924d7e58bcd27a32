"""The recorder's and the replay's nodes, and a session's messages as values."""
