"""Tool paths as a hand guides them: minimum jerk from pose to pose, with a slow tremble that fades at both ends."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mbd_cell.arm.kinematics import DownwardToolPose

TICK = 0.01  # [s]
MIN_DURATION = 0.6  # [s]
TREMBLE_WAVES = 3


def angle_between(start: float, end: float) -> float:
    """Signed shortest turn from start to end [rad], in [-pi, pi)."""
    return (end - start + math.pi) % (2 * math.pi) - math.pi


def guided_path(
    start: DownwardToolPose, end: DownwardToolPose, speed: float, tremble: float, rng: np.random.Generator
) -> Iterator[DownwardToolPose]:
    """Poses for successive control ticks, the last one exactly ``end``.

    Args:
        start: where the tool is.
        end: where it goes; the yaw takes the shorter way round.
        speed: mean speed [m/s].
        tremble: amplitude of the sideways wandering [m]; 0 for a machine's straight path.
        rng: gives the wandering's phases and weights.
    """
    turn = angle_between(start.yaw, end.yaw)
    distance = float(np.linalg.norm(end.position - start.position))
    lean = end.tilt - start.tilt
    duration = max(MIN_DURATION, distance / speed, abs(turn) / 1.5, abs(lean) / 1.5)
    count = max(1, round(duration / TICK))
    # Up to three slow waves along the way, below 1 Hz as a guided arm's are.
    weights = rng.normal(0.0, tremble / TREMBLE_WAVES, (TREMBLE_WAVES, 3))
    phases = rng.uniform(0.0, 2 * math.pi, (TREMBLE_WAVES, 3))
    for tick in range(1, count + 1):
        t = tick / count
        s = t**3 * (10.0 - 15.0 * t + 6.0 * t * t)
        waves = sum(weights[k] * np.sin(2 * math.pi * (k + 1) * 0.5 * t + phases[k]) for k in range(TREMBLE_WAVES))
        position = start.position + s * (end.position - start.position) + math.sin(math.pi * t) ** 2 * waves
        x, y, z = (float(v) for v in position)
        yield DownwardToolPose(x, y, z, start.yaw + s * turn, start.tilt + s * lean)
    if count > 0:
        yield DownwardToolPose(end.x, end.y, end.z, start.yaw + turn, end.tilt)
