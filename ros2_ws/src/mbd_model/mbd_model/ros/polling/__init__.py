"""Topics that are looked at: waking an executor for each message costs ten times what the message does."""
