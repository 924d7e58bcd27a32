"""Whether the gripper's clock and the tool's tell the same time: a hand grasps and lets go while the tool rests."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.trajectory import ToolTrajectory

Floats = NDArray[np.float64]

# A skew is looked for up to so far, in such steps [s].
FARTHEST, STEP = 6.0, 0.05
# Share of the tool's usual travelling speed below which it rests, and above which it travels.
RESTS, TRAVELS = 0.12, 0.4
# So many events must agree on a skew, and none smaller is corrected [s].
AGREEING, SMALLEST = 4, 0.3
# A skew that leaves some event in motion is no skew; neither is one where another a second away would do as well.
APART = 1.0
# A rest shorter than this is a turn between two ways, not an act [s].
IN_PASSING = 0.5
# An object is taken again where it was let go, this near [m].
NEAR_LET_GO = 0.1
# Words come so late or early [s].
WORDS_OFF = 2.0


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


def constant_skew(trajectory: ToolTrajectory, events: Sequence[GripperEvent]) -> float | None:
    """By how much the events must be moved for the tool to rest at all of them [s]; None: not certain, or in time.

    Certain is a skew at which the tool rests at every one of at least four events, where it travels at several of them
    as they are stamped, and besides which no other would do.
    """
    if len(events) < AGREEING:
        return None
    grid, speed = speeds(trajectory)
    at = np.array([e.stamp for e in events])
    shifts = np.arange(-FARTHEST, FARTHEST + STEP, STEP)
    moved = np.interp(at[:, None] + shifts[None, :], grid, speed, left=1.0, right=1.0)
    now = moved[:, int(np.argmin(np.abs(shifts)))]
    if int((now > TRAVELS).sum()) < max(2, len(events) // 3):
        return None
    fits = np.flatnonzero((moved <= RESTS).all(axis=0))
    if not fits.size or shifts[fits[-1]] - shifts[fits[0]] > APART:
        return None
    skew = float(shifts[fits].mean())
    return skew if abs(skew) >= SMALLEST else None


def shifted(events: Iterable[GripperEvent], by: float) -> tuple[GripperEvent, ...]:
    """The events, later by so much [s]."""
    return tuple(dataclasses.replace(e, stamp=e.stamp + by) for e in events)


def words_dated(
    words: Sequence[GripperEvent],
    trajectory: ToolTrajectory,
    fingers: Sequence[GripperEvent] = (),
    near_object: Callable[[float], bool] | None = None,
) -> tuple[tuple[GripperEvent, ...], tuple[str, ...]]:
    """Spoken gripper commands where they were carried out, and a sentence for each that was moved.

    A command spoken while the tool rests is dated as it is stamped. One spoken while it moves is dated by the fingers'
    own event of that kind within two seconds; without fingers by the nearest rest of the tool within two seconds (of a
    closing: one near an object).

    Args:
        words: as stamped, in order.
        trajectory: path of the tool.
        fingers: what the finger joint shows, if it is known.
        near_object: whether the tool is near an object of the source scene at a time [s]; None: not known.
    """
    grid, speed = speeds(trajectory)
    dated: list[GripperEvent] = []
    notes = []
    for word in words:
        same = [e.stamp for e in fingers if e.action is word.action and abs(e.stamp - word.stamp) <= WORDS_OFF]
        let_go = [trajectory.pose_at(e.stamp).position for e in dated if e.action is GripperAction.OPEN]

        def fits(stamp: float, word: GripperEvent = word, let_go: Sequence[Floats] = tuple(let_go)) -> bool:
            if word.action is GripperAction.OPEN or near_object is None or near_object(stamp):
                return True
            here = trajectory.pose_at(stamp).position
            return any(float(np.linalg.norm(here - there)) <= NEAR_LET_GO for there in let_go)

        rest = _nearest_rest(grid, speed, word.stamp, fits)
        if same and (rest is None or abs(rest - word.stamp) > STEP):
            rest = min(same, key=lambda stamp: abs(stamp - word.stamp))
        at = word.stamp if rest is None or abs(rest - word.stamp) <= STEP else rest
        if dated and at <= dated[-1].stamp:
            at = max(word.stamp, dated[-1].stamp)
        if abs(at - word.stamp) > SMALLEST:
            verb = "close" if word.action is GripperAction.CLOSE else "open"
            notes.append(
                f"at {word.stamp - float(trajectory.stamps[0]):.1f} s '{verb}' was said "
                f"{abs(at - word.stamp):.1f} s {'late' if at < word.stamp else 'early'}: dated by "
                f"{'the fingers' if at in same else 'the rest of the tool'}"
            )
        dated.append(dataclasses.replace(word, stamp=at))
    return tuple(dated), tuple(notes)


def _nearest_rest(grid: Floats, speed: Floats, stamp: float, fits: Callable[[float], bool]) -> float | None:
    """When the tool rests nearest to a time within reach [s]; None where it never does."""
    rests = np.flatnonzero(speed <= RESTS)
    runs = np.split(rests, np.flatnonzero(np.diff(rests) > 1) + 1) if rests.size else []
    near = []
    for run in runs:
        # A little inside the rest: at its very edge the tool still arrives, or already leaves.
        inside = grid[run[min(2, run.size // 2) : max(run.size - 2, run.size // 2 + 1)]]
        at = stamp if grid[run[0]] <= stamp <= grid[run[-1]] else float(inside[np.argmin(np.abs(inside - stamp))])
        if abs(at - stamp) <= WORDS_OFF and fits(at):
            # Between two ways the tool is slow too, but only in passing.
            passing = float(grid[run[-1]] - grid[run[0]]) < IN_PASSING
            near.append((passing, abs(at - stamp), at))
    return min(near)[2] if near else None
