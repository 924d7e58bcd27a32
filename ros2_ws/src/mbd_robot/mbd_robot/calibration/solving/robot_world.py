"""Closed forms of A X = Z B: the camera's pose and the board's, both at once.

The methods of OpenCV's calibrateRobotWorldHandEye, by the same names (see ``hand_eye``).

References:
    Shah 2013; Li, Wang, Wu 2010.
"""

from __future__ import annotations

import numpy as np

from mbd_robot.calibration.solving.hand_eye import Array, nearest_rotation
from mbd_robot.calibration.transforms import Transforms, inverse, transform


def shah(arm: Transforms, board: Transforms) -> Transforms:
    """X (4, 4): both rotations by the largest singular pair of the summed Kronecker products, then the places."""
    others = inverse(board)
    total = sum((np.kron(b[:3, :3], a[:3, :3]) for a, b in zip(arm, others, strict=True)), np.zeros((9, 9)))
    u, _, v = np.linalg.svd(total)
    x, z = (_rotation(m.reshape(3, 3, order="F")) for m in (v[0], u[:, 0]))
    return transform(x, _places(x, z, arm, others)[:3])


def li(arm: Transforms, board: Transforms) -> Transforms:
    """X (4, 4): both rotations and both places in one linear system."""
    others, eye = inverse(board), np.eye(3)
    system, wanted = np.zeros((len(arm), 12, 24)), np.zeros((len(arm), 12))
    for i, (a, b) in enumerate(zip(arm, others, strict=True)):
        system[i, :9, :9] = np.kron(eye, a[:3, :3])
        system[i, :9, 9:18] = -np.kron(b[:3, :3].T, eye)
        system[i, 9:, 9:18] = np.kron(b[:3, 3][None, :], eye)
        system[i, 9:, 18:21], system[i, 9:, 21:] = -a[:3, :3], eye
        wanted[i, 9:] = a[:3, 3]
    solved = np.asarray(np.linalg.lstsq(system.reshape(-1, 24), wanted.reshape(-1), rcond=None)[0], dtype=np.float64)
    x, z = (nearest_rotation(m.reshape(3, 3, order="F")) for m in (solved[:9], solved[9:18]))
    return transform(x, _places(x, z, arm, others)[:3])


def _rotation(matrix: Array) -> Array:
    """A rotation of a matrix known up to its scale, sign included."""
    return nearest_rotation(matrix * np.sign(np.linalg.det(matrix)))


def _places(x: Array, z: Array, arm: Transforms, others: Transforms) -> Array:
    """(6,) places of X and Z [m]: R_A t_X - t_Z = R_Z t_B - t_A."""
    system = np.concatenate((arm[:, :3, :3], np.broadcast_to(-np.eye(3), (len(arm), 3, 3))), axis=2)
    wanted = others[:, :3, 3] @ z.T - arm[:, :3, 3]
    return np.asarray(np.linalg.lstsq(system.reshape(-1, 6), wanted.reshape(-1), rcond=None)[0])
