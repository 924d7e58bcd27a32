"""Annotation of sessions in ELAN: a session's events as tiers, what people annotated, and how far two agree."""
