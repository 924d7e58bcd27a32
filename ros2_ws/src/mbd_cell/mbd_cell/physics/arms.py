"""The arms that the cell can be built with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import mujoco

from mbd_cell.physics.robot_model import FLANGE, ArmModel, jaco_folder, packaged_file


def _jaco_arm() -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(jaco_folder() / "jaco_arm.xml"))
    spec.site("wristsite").name = FLANGE
    return spec


def _chain(name: str, tip: str) -> Callable[[], mujoco.MjSpec]:
    """An arm of ``mbd_robot/models``."""

    def load() -> mujoco.MjSpec:
        spec = mujoco.MjSpec.from_file(str(packaged_file("mbd_robot", Path(f"models/{name}.xml"), "mbd_robot")))
        spec.body(tip).add_site(name=FLANGE, group=5)
        return spec

    return load


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
