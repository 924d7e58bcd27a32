"""What a hand's position says: how far it is open, and whether it holds something."""

from __future__ import annotations

from mbd_robot.profiles.robot import HandProfile


def closing(position: float, hand: HandProfile) -> float:
    """How far the hand is closed: 0 open, 1 closed on nothing; both are exceeded where the levels are not exact.

    Args:
        position: mean of the hand's joints [rad or m].
        hand: with its levels; whether larger is more closed follows from them.
    """
    return (position - hand.open) / (hand.closed - hand.open)


def is_holding(position: float, hand: HandProfile) -> bool:
    """Whether a hand that was told to close stopped short of closed, by more than its margin."""
    return closing(position, hand) < 1.0 - hand.holding_margin


def arrived_open(position: float, hand: HandProfile) -> bool:
    """Whether a hand that was told to open is open, within a tenth of its way."""
    return closing(position, hand) < 0.1
