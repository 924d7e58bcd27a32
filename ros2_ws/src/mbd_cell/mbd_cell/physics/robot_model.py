"""What a robot of the cell is: an arm and a hand, what of them moves, touches and closes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy as np
from mbd_model.errors import MbdError

from mbd_cell.physics.grasp import ContactSettings, Grasp

# Where the arm's own flange is, to which hands are fixed: z out of the hand.
FLANGE = "flange"
HAND_PREFIX = "hand/"


@dataclass(frozen=True)
class ForceGrip:
    """How a hand closes by force.

    Attributes:
        gains: kp, kv and largest force of its joints' actuators.
        speed: [rad/s or m/s] of closing and opening.
        squeeze: [rad or m] the first finger is stopped when its target is this far ahead of it: times kp, its force;
            those opposite share it.
        add_pads: gives it what holds by friction, with that friction.
    """

    gains: tuple[float, float, float]
    speed: float
    squeeze: float
    add_pads: Callable[[mujoco.MjSpec, ContactSettings], None]


@dataclass(frozen=True)
class HandModel:
    """A hand in the cell.

    Attributes:
        load: gives its MuJoCo spec, with a body ``body`` and a site ``tool`` between the fingertips: z along the
            fingers, closing along y.
        body: that held things are welded to.
        joints: that close it, larger = more closed.
        finger_bodies: of each finger, the bodies that can touch something; the first finger closes against the others.
        open_angle, closed_angle: of the joints [rad or m].
        speed: [rad/s or m/s]
        press: [rad or m] a finger that pushes on something lags its target by this much.
        gains: kp, kv and largest force of the joints' actuators.
        force: how it closes where friction has to hold.
        radius: [m] half of what the open hand takes up sideways.
    """

    load: Callable[[], mujoco.MjSpec]
    body: str
    joints: tuple[str, ...]
    finger_bodies: tuple[tuple[str, ...], ...]
    open_angle: float
    closed_angle: float
    speed: float
    press: float
    gains: tuple[float, float, float]
    force: ForceGrip
    radius: float = 0.082


@dataclass(frozen=True)
class ArmModel:
    """An arm in the cell.

    Attributes:
        load: gives its MuJoCo spec, with a site ``FLANGE``.
        joints: from the base on.
        home: [rad] joint angles with the hand down at (0.4, 0, 0.3), from which the table is reached without a jump.
        tucked: [rad] folded out of the camera's view.
    """

    load: Callable[[], mujoco.MjSpec]
    joints: tuple[str, ...]
    home: tuple[float, ...]
    tucked: tuple[float, ...]


@dataclass(frozen=True)
class CellRobot:
    """An arm with a hand, and their names in the built model."""

    arm: ArmModel
    hand: HandModel
    prefix: str = "robot/"

    @property
    def arm_joints(self) -> tuple[str, ...]:
        """Of the model, from the base on."""
        return tuple(f"{self.prefix}{name}" for name in self.arm.joints)

    @property
    def hand_joints(self) -> tuple[str, ...]:
        """Of the model."""
        return tuple(f"{self.prefix}{HAND_PREFIX}{name}" for name in self.hand.joints)

    @property
    def finger_bodies(self) -> tuple[tuple[str, ...], ...]:
        """Of the model, for each finger."""
        return tuple(tuple(f"{self.prefix}{HAND_PREFIX}{b}" for b in bodies) for bodies in self.hand.finger_bodies)

    @property
    def hand_body(self) -> str:
        """Of the model: what held things are welded to."""
        return f"{self.prefix}{HAND_PREFIX}{self.hand.body}"

    @property
    def tool_site(self) -> str:
        """Of the model: the tool point."""
        return f"{self.prefix}{HAND_PREFIX}tool"

    def add_to(self, spec: mujoco.MjSpec, grasp: Grasp, contacts: ContactSettings) -> None:
        """Put it into a cell, with its base at the origin, and its actuators; with pads where friction has to hold."""
        arm, hand = self.arm.load(), self.hand.load()
        if grasp is Grasp.FRICTION:
            self.hand.force.add_pads(hand, contacts)
        arm.attach(hand, site=arm.site(FLANGE), prefix=HAND_PREFIX)
        for body in arm.bodies:
            # The real arm's controller carries its own weight.
            body.gravcomp = 1.0
        spec.attach(arm, prefix=self.prefix, frame=spec.worldbody.add_frame())
        for name in self.arm_joints:
            # Armature 2..4 kg m^2: these gains are near critical damping at about 10 Hz.
            _add_position_actuator(spec, name, 12000.0, 420.0, 400.0)
        gains = self.hand.gains if grasp is Grasp.WELD else self.hand.force.gains
        for name in self.hand_joints:
            _add_position_actuator(spec, name, *gains)


def jaco_folder() -> Path:
    """Where dm-control keeps its Jaco2 files.

    Raises:
        MbdError: dm-control is not installed or has no such files.
    """
    return packaged_file("dm_control", Path("third_party/kinova/jaco_arm.xml"), "dm-control").parent


def packaged_file(package: str, file: Path, distribution: str) -> Path:
    """Where an installed package keeps a model; raises MbdError, naming the distribution, when it has none."""
    found = find_spec(package)
    for location in (found.submodule_search_locations or ()) if found else ():
        if (Path(location) / file).is_file():
            return Path(location) / file
    raise MbdError(f"no model {file.name}: the package {distribution} is missing; pip install {distribution}")


def _add_position_actuator(spec: mujoco.MjSpec, joint: str, kp: float, kv: float, limit: float) -> None:
    actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.set_to_position(kp=kp, kv=kv)
    actuator.forcerange = np.array([-limit, limit])
    actuator.forcelimited = True
