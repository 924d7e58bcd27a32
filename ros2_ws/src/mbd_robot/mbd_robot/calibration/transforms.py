"""Rigid transforms in stacks: (..., 4, 4) matrices, their twists and adjoints.

A twist is (rotation [rad], translation [m]), six numbers; ``exponential`` takes its translation as it is, so that a
small twist is the error in turn and the error in place of the frame it is written in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Transforms = NDArray[np.float64]
Vectors = NDArray[np.float64]


def transform(rotation: ArrayLike, position: ArrayLike) -> Transforms:
    """(..., 4, 4) of rotations (..., 3, 3) and positions (..., 3) [m]."""
    turned, moved = np.asarray(rotation, dtype=np.float64), np.asarray(position, dtype=np.float64)
    made = np.zeros((*np.broadcast_shapes(turned.shape[:-2], moved.shape[:-1]), 4, 4))
    made[..., :3, :3], made[..., :3, 3], made[..., 3, 3] = turned, moved, 1.0
    return made


def from_quaternion(position: ArrayLike, quaternion: ArrayLike) -> Transforms:
    """(4, 4) of a position (3,) [m] and a quaternion (x, y, z, w)."""
    return transform(Rotation.from_quat(np.asarray(quaternion)).as_matrix(), position)


def inverse(transforms: Transforms) -> Transforms:
    """(..., 4, 4) that undo these."""
    turned = np.swapaxes(transforms[..., :3, :3], -1, -2)
    return transform(turned, -np.einsum("...ij,...j->...i", turned, transforms[..., :3, 3]))


def exponential(twists: Vectors) -> Transforms:
    """(..., 4, 4) of twists (..., 6): turned by the first three [rad], moved by the last three [m]."""
    flat = np.asarray(twists, dtype=np.float64).reshape(-1, 6)
    made = transform(Rotation.from_rotvec(flat[:, :3]).as_matrix(), flat[:, 3:])
    return made.reshape(*np.shape(twists)[:-1], 4, 4)


def logarithm(transforms: Transforms) -> Vectors:
    """(..., 6) twists [rad, m] of (..., 4, 4): the inverse of ``exponential``."""
    flat = np.asarray(transforms).reshape(-1, 4, 4)
    turns = Rotation.from_matrix(flat[:, :3, :3]).as_rotvec()
    return np.concatenate((turns, flat[:, :3, 3]), axis=1).reshape(*np.shape(transforms)[:-2], 6)


def skew(vectors: Vectors) -> Vectors:
    """(..., 3, 3) matrices of the cross product with (..., 3)."""
    x, y, z = (vectors[..., k] for k in range(3))
    zero = np.zeros_like(x)
    rows = [np.stack(row, axis=-1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))]
    return np.stack(rows, axis=-2)


def adjoint(transforms: Transforms) -> Vectors:
    """(..., 6, 6) that take a small twist from the transform's inner frame to its outer one."""
    turned = transforms[..., :3, :3]
    made = np.zeros((*transforms.shape[:-2], 6, 6))
    made[..., :3, :3] = made[..., 3:, 3:] = turned
    made[..., 3:, :3] = skew(transforms[..., :3, 3]) @ turned
    return made


def mean_transform(transforms: Transforms) -> Transforms:
    """(4, 4) in the middle of (n, 4, 4): mean rotation (chordal), median place."""
    return transform(
        Rotation.from_matrix(transforms[:, :3, :3]).mean().as_matrix(), np.median(transforms[:, :3, 3], axis=0)
    )
