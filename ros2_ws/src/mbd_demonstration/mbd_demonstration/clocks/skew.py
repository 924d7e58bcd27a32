"""Whether the gripper's clock and the tool's tell the same time: a hand grasps and lets go while the tool rests."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.trajectory import ToolTrajectory

Floats = NDArray[np.float64]

# A skew is looked for up to so far, in such steps [s].
FARTHEST, STEP = 6.0, 0.05
# Share of the tool's usual travelling speed below which it rests, and above which it travels.
RESTS, TRAVELS = 0.12, 0.4
# So many events must agree on a skew, and none smaller is corrected [s].
AGREEING, SMALLEST = 4, 0.3
# Of the events, how many a skew must leave at rest; and how far from it another one is another [s].
NEARLY, APART = 0.8, 1.0


def speeds(trajectory: ToolTrajectory, window: float = 0.2) -> tuple[Floats, Floats]:
    """(times (n,) [s], speed of the tool (n,) as a share of its usual travelling speed), on an even grid."""
    begin, end = float(trajectory.stamps[0]), float(trajectory.stamps[-1])
    grid = np.arange(begin, end + STEP, STEP)
    half = 0.5 * max(window, float(np.median(np.diff(trajectory.stamps))) if trajectory.stamps.size > 1 else window)
    ends = (np.clip(grid + half, begin, end), np.clip(grid - half, begin, end))
    after, before = (
        np.stack([np.interp(at, trajectory.stamps, trajectory.positions[:, k]) for k in range(3)], axis=1)
        for at in ends
    )
    speed = np.linalg.norm(after - before, axis=1) / np.maximum(ends[0] - ends[1], STEP)
    travelling = float(np.quantile(speed, 0.9)) if speed.size else 0.0
    return grid, speed / travelling if travelling > 0.0 else speed


@dataclasses.dataclass(frozen=True)
class SkewFound:
    """Whether the gripper's clock tells the tool's time.

    Attributes:
        by: the events must be moved by it for the tool to rest at them [s]; None: in time, or not certain.
        moving: at how many of the events the tool travels, as they are stamped; 0 where nothing looks wrong.
    """

    by: float | None = None
    moving: int = 0


def find_skew(trajectory: ToolTrajectory, events: Sequence[GripperEvent]) -> SkewFound:
    """By how much the gripper's clock is off the tool's.

    Certain is a skew at which the tool rests at nearly all of at least four events, at a third of which it travels as
    they are stamped, and besides which none other would nearly do. Where a whole stretch of skews does so, the tool
    rests all that while: then its middle gives the same poses as any other.
    """
    if len(events) < AGREEING:
        return SkewFound()
    grid, speed = speeds(trajectory)
    at = np.array([e.stamp for e in events])
    shifts = np.arange(-FARTHEST, FARTHEST + STEP, STEP)
    moved = np.interp(at[:, None] + shifts[None, :], grid, speed, left=1.0, right=1.0)
    moving = int((moved[:, int(np.argmin(np.abs(shifts)))] > TRAVELS).sum())
    if moving < max(2, len(events) // 3):
        return SkewFound()
    resting = (moved <= RESTS).sum(axis=0)
    best = int(resting.max())
    if best < max(AGREEING, math.ceil(NEARLY * len(events))):
        return SkewFound(moving=moving)
    fits = np.flatnonzero(resting == best)
    runs = np.split(fits, np.flatnonzero(np.diff(fits) > 1) + 1)
    longest = max(runs, key=len)
    outside = np.abs(shifts - np.clip(shifts, shifts[longest[0]] - APART, shifts[longest[-1]] + APART)) > 0.0
    rival = int(resting[outside].max(initial=0))
    if rival > best - max(2, len(events) // 4) and (rival == len(events) or best < len(events)):
        return SkewFound(moving=moving)
    skew = float(shifts[longest].mean())
    return SkewFound(skew, moving) if abs(skew) >= SMALLEST else SkewFound()


def shifted(events: Iterable[GripperEvent], by: float) -> tuple[GripperEvent, ...]:
    """The events, later by so much [s]."""
    return tuple(dataclasses.replace(e, stamp=e.stamp + by) for e in events)
