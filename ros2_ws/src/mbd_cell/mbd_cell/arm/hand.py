"""The three-finger hand: opens and closes over time, and holds what it has really closed around."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mbd_cell.physics.simulation import Simulation

# Open enough for 9 cm between the fingers, narrow enough not to touch the neighbours; the joints' range is 0.15..1.35.
OPEN_ANGLE = 0.40
CLOSED_ANGLE = 1.30
SPEED = 1.1  # [rad/s]
TICK = 0.01  # [s]
# A finger that pushes on something lags its target by this much [rad]; then the target waits: it presses gently.
PRESS = 0.06
SETTLED_TICKS = 8


class GripperCommand(IntEnum):
    """What the hand is commanded; values equal mbd_msgs/WizardGripper and mbd_msgs/MoveGripper."""

    OPEN = 1
    CLOSE = 2


class Hand:
    """Finger targets tick by tick, and the grasp.

    An object is held from the moment two or more fingers, finger 1 and one opposite, press on it while closing; it is
    let go as soon as the hand opens.
    """

    def __init__(self) -> None:
        self.command = GripperCommand.OPEN
        self.held: str | None = None
        self.target = np.full(3, OPEN_ANGLE)
        self._ticks_at_rest = SETTLED_TICKS

    @property
    def settled(self) -> bool:
        """True when the fingers have done what they were commanded."""
        return self._ticks_at_rest >= SETTLED_TICKS

    @property
    def opening(self) -> float:
        """0 closed .. 1 open."""
        return float(np.clip((CLOSED_ANGLE - self.target.mean()) / (CLOSED_ANGLE - OPEN_ANGLE), 0.0, 1.0))

    def move(self, command: GripperCommand, simulation: Simulation) -> None:
        """Start to open or close; opening lets go at once."""
        self.command = command
        self._ticks_at_rest = 0
        if command is GripperCommand.OPEN:
            self.release(simulation)

    def release(self, simulation: Simulation) -> None:
        """Hold nothing any more."""
        if self.held is not None:
            simulation.let_go(self.held)
            self.held = None

    def tick(self, simulation: Simulation) -> NDArray[np.float64]:
        """Targets of the fingers (3,) [rad] for the next control tick."""
        before = self.target.copy()
        if self.command is GripperCommand.OPEN:
            self.target = np.maximum(self.target - SPEED * TICK, OPEN_ANGLE)
        elif self.held is None:
            pressing = self.target - simulation.finger_joints > PRESS
            self.target = np.where(pressing, self.target, np.minimum(self.target + SPEED * TICK, CLOSED_ANGLE))
            self._grasp(simulation)
        self._ticks_at_rest = self._ticks_at_rest + 1 if np.array_equal(before, self.target) else 0
        return self.target

    def _grasp(self, simulation: Simulation) -> None:
        for name, fingers in sorted(simulation.touching_fingers().items()):
            if 1 in fingers and fingers & {2, 3}:
                simulation.hold(name)
                self.held = name
                return
