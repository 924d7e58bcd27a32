"""Between float seconds, in which times are reckoned, and integer nanoseconds, in which stamps and bags hold them."""

from __future__ import annotations


def to_seconds(nanoseconds: int) -> float:
    """Nanoseconds as seconds."""
    return nanoseconds / 1e9


def to_nanoseconds(seconds: float) -> int:
    """Seconds as nanoseconds, rounded."""
    return round(seconds * 1e9)
