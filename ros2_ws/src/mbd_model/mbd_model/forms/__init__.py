"""Forms that participants fill in: consent, questionnaires and free ones, read from YAML, and what is answered."""
