"""What teachers may have in mind, how likely each is, and what their assists say of it."""
