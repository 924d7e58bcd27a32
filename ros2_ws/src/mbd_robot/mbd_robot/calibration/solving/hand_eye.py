"""Closed forms of A X = X B: the camera's pose from how arm and board moved between pictures.

The methods of OpenCV's calibrateHandEye, by the same names; OpenCV 5's Python has them no longer. Everywhere
``arm[i] @ X @ board[i]`` is the same for every picture i (see ``problem``).

References:
    Tsai, Lenz 1989; Park, Martin 1994; Horaud, Dornaika 1995; Andreff et al. 1999; Daniilidis 1999.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.transforms import Transforms, inverse, skew, transform

Array = NDArray[np.float64]


def tsai(arm: Transforms, board: Transforms) -> Transforms:
    """X (4, 4) by modified Rodrigues vectors, then its place."""
    a, b = _motions(arm, board)
    p, q = (_rodrigues(m[:, :3, :3]) for m in (a, b))
    v = np.linalg.lstsq(skew(p + q).reshape(-1, 3), (q - p).reshape(-1), rcond=None)[0]
    v = 2.0 * v / np.sqrt(1.0 + v @ v)
    squared = float(v @ v)
    turn = (1.0 - squared / 2.0) * np.eye(3) + 0.5 * (
        np.outer(v, v) + np.sqrt(max(4.0 - squared, 0.0)) * skew(v)
    )  # fmt: skip
    return _placed(nearest_rotation(turn), a, b)


def park(arm: Transforms, board: Transforms) -> Transforms:
    """X (4, 4): the turn that takes the board's rotation vectors to the arm's, then its place."""
    a, b = _motions(arm, board)
    alpha, beta = (Rotation.from_matrix(m[:, :3, :3]).as_rotvec() for m in (a, b))
    return _placed(nearest_rotation(alpha.T @ beta), a, b)


def horaud(arm: Transforms, board: Transforms) -> Transforms:
    """X (4, 4): the unit quaternion nearest to all rotations, then its place."""
    a, b = _motions(arm, board)
    p, q = (Rotation.from_matrix(m[:, :3, :3]).as_quat(canonical=True, scalar_first=True) for m in (a, b))
    wanted = _left(p) - _right(q)
    values, vectors = np.linalg.eigh(np.einsum("nij,nik->jk", wanted, wanted))
    turn = Rotation.from_quat(vectors[:, int(np.argmin(values))], scalar_first=True).as_matrix()
    return _placed(turn, a, b)


def andreff(arm: Transforms, board: Transforms) -> Transforms:
    """X (4, 4): rotation and place in one linear system, then the nearest rotation."""
    a, b = _motions(arm, board)
    count, eye = len(a), np.eye(3)
    system, wanted = np.zeros((count, 12, 12)), np.zeros((count, 12))
    for i in range(count):
        turned, other = a[i, :3, :3], b[i, :3, :3]
        system[i, :9, :9] = np.kron(eye, turned) - np.kron(other.T, eye)
        system[i, 9:, :9] = np.kron(b[i, :3, 3][None, :], eye)
        system[i, 9:, 9:] = eye - turned
        wanted[i, 9:] = a[i, :3, 3]
    solved = np.asarray(np.linalg.lstsq(system.reshape(-1, 12), wanted.reshape(-1), rcond=None)[0], dtype=np.float64)
    return _placed(nearest_rotation(solved[:9].reshape(3, 3, order="F")), a, b)


def daniilidis(arm: Transforms, board: Transforms) -> Transforms:
    """X (4, 4): rotation and place at once, as a dual quaternion."""
    a, b = _motions(arm, board)
    p, q = (Rotation.from_matrix(m[:, :3, :3]).as_quat(canonical=True, scalar_first=True) for m in (a, b))
    p_dual, q_dual = _dual(p, a[:, :3, 3]), _dual(q, b[:, :3, 3])
    real, dual = _left(p) - _right(q), _left(p_dual) - _right(q_dual)
    rows = np.concatenate((np.concatenate((real, np.zeros_like(real)), axis=2), np.concatenate((dual, real), axis=2)))
    null = np.linalg.svd(rows.reshape(-1, 8), full_matrices=False)[2][-2:]
    # s * null[0] + t * null[1] with a unit real part, and the dual part at right angles to it.
    (u1, v1), (u2, v2) = ((n[:4], n[4:]) for n in null)
    roots = np.roots([u1 @ v1, u1 @ v2 + u2 @ v1, u2 @ v2])
    ratios = np.real(roots[np.abs(roots.imag) < 1e-6]) if len(roots) else np.zeros(1)
    if not len(ratios):
        ratios = np.real(roots)
    lengths = [r * r * (u1 @ u1) + 2 * r * (u1 @ u2) + u2 @ u2 for r in ratios]
    best = int(np.argmax(lengths))
    made = (ratios[best] * null[0] + null[1]) / np.sqrt(lengths[best])
    turn = Rotation.from_quat(made[:4], scalar_first=True)
    conjugate = made[:4] * (1.0, -1.0, -1.0, -1.0)
    place = 2.0 * (_left(made[None, 4:])[0] @ conjugate)[1:]
    return transform(turn.as_matrix(), place)


def nearest_rotation(matrix: Array) -> Array:
    """(3, 3) rotation nearest to a matrix, whatever its scale."""
    u, _, v = np.linalg.svd(matrix)
    return np.asarray(u @ np.diag((1.0, 1.0, np.linalg.det(u @ v))) @ v)


def _motions(arm: Transforms, board: Transforms) -> tuple[Transforms, Transforms]:
    """A and B between every two pictures."""
    first, second = np.array(list(combinations(range(len(arm)), 2))).T
    return inverse(arm[second]) @ arm[first], board[second] @ inverse(board[first])


def _placed(turn: Array, a: Transforms, b: Transforms) -> Transforms:
    """X of its rotation: (R_A - I) t = R_X t_B - t_A."""
    system = (a[:, :3, :3] - np.eye(3)).reshape(-1, 3)
    wanted = (b[:, :3, 3] @ turn.T - a[:, :3, 3]).reshape(-1)
    return transform(turn, np.linalg.lstsq(system, wanted, rcond=None)[0])


def _rodrigues(turns: Array) -> Array:
    """(n, 3) of 2 sin(angle / 2) along the axis."""
    vectors = Rotation.from_matrix(turns).as_rotvec()
    angles = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors * np.sinc(angles / (2.0 * np.pi)))


def _left(q: Array) -> Array:
    """(n, 4, 4) that multiply by q (n, 4; w, x, y, z) from the left."""
    return _product(q, 1.0)


def _right(q: Array) -> Array:
    """(n, 4, 4) that multiply by q from the right."""
    return _product(q, -1.0)


def _product(q: Array, sign: float) -> Array:
    made = np.empty((len(q), 4, 4))
    made[:, 0, 0], made[:, 0, 1:], made[:, 1:, 0] = q[:, 0], -q[:, 1:], q[:, 1:]
    made[:, 1:, 1:] = q[:, 0, None, None] * np.eye(3) + sign * skew(q[:, 1:])
    return made


def _dual(q: Array, place: Array) -> Array:
    pure = np.concatenate((np.zeros((len(q), 1)), place), axis=1)
    return np.asarray(0.5 * np.einsum("nij,nj->ni", _left(pure), q))
