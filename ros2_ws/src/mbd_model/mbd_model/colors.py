"""Colours with a meaning, the same in every picture and page: how a pair of a mapping became known."""

from __future__ import annotations

# Assisted by the teacher, predicted, predicted but known to be wrong.
ASSISTED, PREDICTED, WRONG = "#f28e2b", "#2f7fd1", "#d62839"
