"""The arm's links as points of their surfaces, where joint angles put them."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.kinematics.chain import ArmChain

AROUND = 16  # points of a circle


def arm_shapes(chain: ArmChain, joints: Mapping[str, float]) -> list[NDArray[np.float64]]:
    """(n, 3) points [m, base frame] of each link's surface.

    Args:
        chain: of the arm.
        joints: position [rad] by name; more than the arm's are passed over.

    Raises:
        CalibrationError: a joint of the arm is missing.
    """
    names = chain.profile.arm.joints
    missing = [name for name in names if name not in joints]
    if missing:
        raise CalibrationError(f"no position of joint {', '.join(missing)}; there are {', '.join(joints) or 'none'}")
    chain.at(np.array([joints[name] for name in names]))
    shapes = []
    for geom in chain.links:
        size, kind = chain.model.geom_size[geom], int(chain.model.geom_type[geom])
        points = _surface(kind, size, chain.model, geom)
        shapes.append(points @ chain.data.geom_xmat[geom].reshape(3, 3).T + chain.data.geom_xpos[geom])
    return shapes


def _surface(
    kind: int, size: NDArray[np.float64], model: mujoco.MjModel, geom: int
) -> NDArray[np.float64]:  # fmt: skip
    """(n, 3) points in the geom's own frame, whose hull is its shape."""
    kinds = mujoco.mjtGeom
    if kind == kinds.mjGEOM_BOX:
        return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    if kind == kinds.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        return np.asarray(model.mesh_vert[first : first + count], dtype=np.float64)
    turns = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    circle = np.stack((np.cos(turns), np.sin(turns)), axis=1)
    if kind == kinds.mjGEOM_CYLINDER:
        return np.concatenate([np.column_stack((circle * size[0], np.full(AROUND, s * size[1]))) for s in (-1, 1)])
    heights = np.array([-0.9, -0.5, 0.0, 0.5, 0.9, 1.0, -1.0])
    ball = np.concatenate(
        [np.column_stack((circle * np.sqrt(1.0 - h * h), np.full(AROUND, h))) for h in heights]
    )  # fmt: skip
    half = float(size[1]) if kind == kinds.mjGEOM_CAPSULE else 0.0
    radii = size if kind == kinds.mjGEOM_ELLIPSOID else np.full(3, float(size[0]))
    return np.concatenate([ball * radii + (0.0, 0.0, s * half) for s in (-1, 1)])
