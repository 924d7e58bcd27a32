"""Whether an arm that says it can be guided by hand really can: gripper events, and a tool that never moves."""

from __future__ import annotations

import math

STIFF = 0.02  # [m] a guided tool moves farther than this between two acts of the hand
EVENTS = 2  # closings and openings after which a tool that has not moved is stiff
UNUSED = 30.0  # [s] without any movement, after which it is asked about


class StiffArmWatch:
    """Watches a demonstration.

    Attributes:
        travelled: [m] the tool's farthest from where the guiding began.
        events: closings and openings since.
    """

    def __init__(self) -> None:
        self._begun: float | None = None
        self._first: tuple[float, float, float] | None = None
        self.travelled = 0.0
        self.events = 0

    def begin(self, now: float) -> None:
        """The arm is said to be soft from now [s] on."""
        self._begun, self._first, self.travelled, self.events = now, None, 0.0, 0

    def end(self) -> None:
        """Nothing is watched any more."""
        self._begun = None

    def tool_at(self, position: tuple[float, float, float]) -> None:
        """Where the tool is [m]."""
        if self._begun is None:
            return
        if self._first is None:
            self._first = position
        self.travelled = max(self.travelled, math.dist(position, self._first))

    def gripper_event(self) -> None:
        """The hand was told to close or to open."""
        if self._begun is not None:
            self.events += 1

    def complaint(self, now: float) -> str:
        """What is wrong, for people; "" for nothing."""
        if self._begun is None or self.travelled > STIFF:
            return ""
        moved = f"the tool has moved {self.travelled * 1000:.0f} mm"
        if self.events >= EVENTS:
            return (
                f"the arm says it can be guided, but in {self.events} closings and openings of the hand {moved}: it is "
                "stiff, or its driver's tool pose stands still; switch hand guiding on again, or do what the robot's "
                "page says"
            )
        if now - self._begun > UNUSED:
            return f"hand guiding has been on for {now - self._begun:.0f} s and {moved}: is the arm stiff?"
        return ""
