"""The hand: opens and closes over time, and holds what it has really closed around."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mbd_cell.physics.grasp import Grasp
from mbd_cell.physics.robot_model import HandModel
from mbd_cell.physics.robots import JACO
from mbd_cell.physics.simulation import Simulation

TICK = 0.01  # [s]
SETTLED_TICKS = 8
# A finger that moves less in a tick stands still [share of its way]: it has closed around something.
STILL = 1e-3
# A hand that closed on nothing is no further open: its own fingers meet.
SHUT = 0.04
# A finger presses when its target is this share of the squeeze ahead.
ENOUGH = 0.8
UNSURE = 0.25
# Contact that fails for fewer ticks is no object lost: it is shaken.
LOST_TICKS = 5


class GripperCommand(IntEnum):
    """What the hand is commanded; values equal mbd_msgs/WizardGripper and mbd_msgs/MoveGripper."""

    OPEN = 1
    CLOSE = 2


class Hand:
    """Finger targets tick by tick, and the grasp.

    With ``Grasp.WELD`` an object is held from the moment two or more fingers, finger 1 and one opposite, touch it while
    closing; it is let go as soon as the hand opens. A finger that pushes on something lags its target; then the target
    waits: it presses gently.

    With ``Grasp.FRICTION`` each finger closes until it is stopped and then presses with a limited force, and what is
    held is what finger 1 and one opposite press between them at that moment: it can be lost.
    """

    def __init__(self, model: HandModel = JACO.hand, grasp: Grasp = Grasp.WELD) -> None:
        self.model = model
        self.grasp = grasp
        self.command = GripperCommand.OPEN
        self.held: str | None = None
        self.target = np.full(len(model.joints), model.open_angle)
        self._ticks_at_rest = float(SETTLED_TICKS)
        self._joints = self.target.copy()
        self._pressing = np.zeros(len(model.joints), dtype=bool)
        self._ticks_unpressed = 0
        # Two fingers that each pressed as hard as the one opposite would push it, and what is held, ever farther.
        opposite = len(model.joints) - 1
        self._squeeze = model.force.squeeze * np.array([1.0] + [1.0 / opposite] * opposite)

    @property
    def settled(self) -> bool:
        """True when the fingers have done what they were commanded."""
        return self._ticks_at_rest >= SETTLED_TICKS

    @property
    def opening(self) -> float:
        """0 closed .. 1 open."""
        way = self.model.closed_angle - self.model.open_angle
        fingers = self.target if self.grasp is Grasp.WELD else self._joints
        return float(np.clip((self.model.closed_angle - fingers.mean()) / way, 0.0, 1.0))

    @property
    def stopped(self) -> bool:
        """True when something keeps the closed hand open, as its own joints show it."""
        if self.grasp is Grasp.WELD:
            return self.held is not None
        return self.command is GripperCommand.CLOSE and self.settled and self.opening > SHUT

    def move(self, command: GripperCommand, simulation: Simulation) -> None:
        """Start to open or close; opening lets go at once."""
        self.command = command
        self._ticks_at_rest = 0.0
        self._pressing[:] = False
        if command is GripperCommand.OPEN:
            if self.grasp is Grasp.FRICTION:
                # All fingers leave at once: the one that was pressing hardest would push what the others have left.
                self.target = np.minimum(self.target, simulation.finger_joints)
            self.release(simulation)

    def release(self, simulation: Simulation) -> None:
        """Hold nothing any more."""
        if self.held is not None and self.grasp is Grasp.WELD:
            simulation.let_go(self.held)
        self.held = None

    def tick(self, simulation: Simulation) -> NDArray[np.float64]:
        """Targets of the fingers (F,) [rad or m] for the next control tick."""
        if self.grasp is Grasp.FRICTION:
            return self._tick_by_force(simulation)
        before, step = self.target.copy(), self.model.speed * TICK
        if self.command is GripperCommand.OPEN:
            self.target = np.maximum(self.target - step, self.model.open_angle)
        elif self.held is None:
            pressing = self.target - simulation.finger_joints > self.model.press
            self.target = np.where(pressing, self.target, np.minimum(self.target + step, self.model.closed_angle))
            self._grasp(simulation)
        self._ticks_at_rest = self._ticks_at_rest + 1 if np.array_equal(before, self.target) else 0
        return self.target

    def _tick_by_force(self, simulation: Simulation) -> NDArray[np.float64]:
        model, force, joints = self.model, self.model.force, simulation.finger_joints
        moved, step = joints - self._joints, force.speed * TICK
        still = float(np.abs(moved).max()) < STILL * (model.closed_angle - model.open_angle)
        # What the actuator's own damping takes of the lead is no force on an object.
        lead = self.target - joints - force.gains[1] / force.gains[0] * moved / TICK
        if self.command is GripperCommand.OPEN:
            self.target = np.maximum(self.target - step, model.open_angle)
            arrived = self.target == model.open_angle
        else:
            pressing = lead > ENOUGH * self._squeeze
            # Stopped by something, a finger keeps no more lead than its grip takes. From then on its target never goes
            # back, so that it does not yield to the fingers opposite.
            eased = np.where(self._pressing, self.target, np.minimum(self.target, joints + self._squeeze))
            self.target = np.where(pressing, eased, np.minimum(self.target + step, model.closed_angle))
            self._pressing = pressing
            arrived = pressing | (self.target == model.closed_angle)
            self._look_what_is_pressed(simulation)
        self._joints = joints
        # What neither presses nor arrives, yet stands still, is stuck.
        self._ticks_at_rest += (1.0 if arrived.all() else UNSURE) if still else -self._ticks_at_rest
        return self.target

    def _look_what_is_pressed(self, simulation: Simulation) -> None:
        pressed = simulation.pressed()
        self._ticks_unpressed = 0 if pressed == self.held else self._ticks_unpressed + 1
        if self._ticks_unpressed >= LOST_TICKS:
            self.held = pressed

    def _grasp(self, simulation: Simulation) -> None:
        for name, fingers in sorted(simulation.touching_fingers().items()):
            if 1 in fingers and len(fingers) > 1:
                simulation.hold(name)
                self.held = name
                return
