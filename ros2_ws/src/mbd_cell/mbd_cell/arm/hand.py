"""The hand: opens and closes over time, and holds what it has really closed around."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mbd_cell.physics.robots import JACO, HandModel
from mbd_cell.physics.simulation import Simulation

TICK = 0.01  # [s]
SETTLED_TICKS = 8


class GripperCommand(IntEnum):
    """What the hand is commanded; values equal mbd_msgs/WizardGripper and mbd_msgs/MoveGripper."""

    OPEN = 1
    CLOSE = 2


class Hand:
    """Finger targets tick by tick, and the grasp.

    An object is held from the moment two or more fingers, finger 1 and one opposite, press on it while closing; it is
    let go as soon as the hand opens. A finger that pushes on something lags its target; then the target waits: it
    presses gently.
    """

    def __init__(self, model: HandModel = JACO.hand) -> None:
        self.model = model
        self.command = GripperCommand.OPEN
        self.held: str | None = None
        self.target = np.full(len(model.joints), model.open_angle)
        self._ticks_at_rest = SETTLED_TICKS

    @property
    def settled(self) -> bool:
        """True when the fingers have done what they were commanded."""
        return self._ticks_at_rest >= SETTLED_TICKS

    @property
    def opening(self) -> float:
        """0 closed .. 1 open."""
        way = self.model.closed_angle - self.model.open_angle
        return float(np.clip((self.model.closed_angle - self.target.mean()) / way, 0.0, 1.0))

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
        """Targets of the fingers (F,) [rad or m] for the next control tick."""
        before, step = self.target.copy(), self.model.speed * TICK
        if self.command is GripperCommand.OPEN:
            self.target = np.maximum(self.target - step, self.model.open_angle)
        elif self.held is None:
            pressing = self.target - simulation.finger_joints > self.model.press
            self.target = np.where(pressing, self.target, np.minimum(self.target + step, self.model.closed_angle))
            self._grasp(simulation)
        self._ticks_at_rest = self._ticks_at_rest + 1 if np.array_equal(before, self.target) else 0
        return self.target

    def _grasp(self, simulation: Simulation) -> None:
        for name, fingers in sorted(simulation.touching_fingers().items()):
            if 1 in fingers and len(fingers) > 1:
                simulation.hold(name)
                self.held = name
                return
