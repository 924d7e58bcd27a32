"""When the arm is where on its way: jerk-limited, within every joint's velocity and acceleration (ruckig)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import ruckig
from mbd_model.errors import MbdError
from numpy.typing import NDArray

PERIOD = 0.05  # [s] between two points of a trajectory


NOWHERE = 1e-4  # [m or rad] a way so short is none


@dataclass(frozen=True)
class TimedJoints:
    """A joint trajectory that begins and ends at rest.

    Attributes:
        times: (N,) [s] from the start, the first 0.
        positions: (N, J) [rad]
        velocities: (N, J) [rad/s]
    """

    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]

    @property
    def duration(self) -> float:
        """[s]."""
        return float(self.times[-1])


@dataclass(frozen=True)
class JointLimits:
    """What the joints may do: velocity (J,) [rad/s], acceleration [rad/s^2], jerk [rad/s^3]."""

    velocity: NDArray[np.float64]
    acceleration: float
    jerk: float


def swing(start: NDArray[np.float64], goal: NDArray[np.float64], limits: JointLimits) -> TimedJoints:
    """All joints at once from rest to rest, the slowest deciding; start and goal (J,) [rad].

    Raises:
        MbdError: ruckig finds no trajectory.
    """
    trajectory = _profile(start, goal, limits.velocity, limits.acceleration, limits.jerk)
    times = _instants(trajectory.duration)
    states = [trajectory.at_time(float(t)) for t in times]
    return TimedJoints(times, np.array([s[0] for s in states]), np.array([s[1] for s in states]))


def along(way: NDArray[np.float64], lengths: NDArray[np.float64], speed: float, limits: JointLimits) -> TimedJoints:
    """A way of the joints in order, as fast as ``speed`` and the joints' limits let it.

    Args:
        way: (N, J) [rad], close together.
        lengths: (N,) [m or rad] how far along the way each is, rising from 0.
        speed: largest speed along it [m/s or rad/s].
        limits: of the joints.

    Raises:
        MbdError: ruckig finds no trajectory.
    """
    total = float(lengths[-1])
    if total < NOWHERE:
        return TimedJoints(np.array((0.0, PERIOD)), way[[0, -1]], np.zeros((2, way.shape[1])))
    slope = np.gradient(way, lengths, axis=0)
    bend = np.gradient(slope, lengths, axis=0)
    fastest = float(np.min(limits.velocity / np.maximum(np.abs(slope).max(axis=0), 1e-9)))
    bent = float(np.abs(bend).max())
    # A joint accelerates by slope * s'' and by bend * s'^2: each gets half of what it may.
    fastest = min(speed, fastest, float(np.sqrt(0.5 * limits.acceleration / max(bent, 1e-9))))
    steepest = max(float(np.abs(slope).max()), 1e-9)
    acceleration, jerk = 0.5 * limits.acceleration / steepest, limits.jerk / steepest
    profile = _profile(np.zeros(1), np.array([total]), np.array([fastest]), acceleration, jerk)
    times = _instants(profile.duration)
    states = [profile.at_time(float(t)) for t in times]
    place = np.clip([s[0][0] for s in states], 0.0, total)
    rate = np.array([s[1][0] for s in states])
    positions = np.stack([np.interp(place, lengths, way[:, j]) for j in range(way.shape[1])], axis=1)
    slopes = np.stack([np.interp(place, lengths, slope[:, j]) for j in range(way.shape[1])], axis=1)
    velocities = slopes * rate[:, None]
    positions[0], positions[-1], velocities[0], velocities[-1] = way[0], way[-1], 0.0, 0.0
    return TimedJoints(times, positions, velocities)


def joined(one: TimedJoints, other: TimedJoints) -> TimedJoints:
    """One after the other."""
    return TimedJoints(
        np.concatenate((one.times, one.duration + other.times[1:])),
        np.concatenate((one.positions, other.positions[1:])),
        np.concatenate((one.velocities, other.velocities[1:])),
    )


def _instants(duration: float) -> NDArray[np.float64]:
    """Times from 0 to the end; drivers want them to rise, also where there is no way to go."""
    duration = max(duration, PERIOD)
    return np.linspace(0.0, duration, max(2, int(np.ceil(duration / PERIOD)) + 1))


def _profile(
    start: NDArray[np.float64],
    goal: NDArray[np.float64],
    velocity: NDArray[np.float64],
    acceleration: float,
    jerk: float,
) -> ruckig.Trajectory:
    count = len(start)
    wanted = ruckig.InputParameter(count)
    wanted.current_position, wanted.target_position = list(start), list(goal)
    wanted.max_velocity, wanted.max_acceleration = list(velocity), [acceleration] * count
    wanted.max_jerk = [jerk] * count
    trajectory = ruckig.Trajectory(count)
    result = ruckig.Ruckig(count).calculate(wanted, trajectory)
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise MbdError(f"no trajectory from {list(start)} to {list(goal)}: ruckig says {result}")
    return trajectory
