"""Gripper events from the position of a finger joint: hysteresis and debounce.

Closure is 0 when open and 1 when closed, between two levels of the joint. The levels are given for a known hand, or
learned from the recording: then 0 and 1 are the ends of the range it went through, so that a grasp that stops at an
object's width is still a closing, whatever hand, unit and object it was. The same function serves recorded files and
the live node, which calls it on what it has recorded so far.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import ArrayLike, NDArray

from mbd_demonstration.gripper import GripperAction, GripperEvent

RESTED = 1.0  # [s] a hand stopped on its way this long may hold something wide


class Polarity(StrEnum):
    """Which way the joint's numbers go; learned levels need it, given levels imply it."""

    LARGER_CLOSED = "larger_closed"
    LARGER_OPEN = "larger_open"


@dataclass(frozen=True)
class FingerJointConfig:
    """How closings are read off a finger joint.

    Attributes:
        polarity: used when the levels are learned.
        open_level, closed_level: joint positions of the open and closed hand, NaN to learn both from the recording.
        close_at, open_at: closure at and above which an open gripper has closed; at and below which a closed one
            has opened. The gap between them is the hysteresis.
        debounce: [s] a change must last; shorter ones are glitches of the joint or of the bus.
        min_travel: [joint unit] a gripper whose learned range is smaller never moved.
    """

    polarity: Polarity = Polarity.LARGER_CLOSED
    open_level: float = math.nan
    closed_level: float = math.nan
    close_at: float = 0.65
    open_at: float = 0.35
    debounce: float = 0.1
    min_travel: float = 0.005

    def __post_init__(self) -> None:
        """Validate once; raises MbdError naming the field."""
        if not 0.0 < self.open_at < self.close_at < 1.0:
            raise MbdError(f"need 0 < open_at < close_at < 1 for hysteresis: got {self.open_at} and {self.close_at}")
        if math.isnan(self.open_level) != math.isnan(self.closed_level):
            raise MbdError(
                f"open_level {self.open_level} and closed_level {self.closed_level}: give both, or NaN for both"
            )
        if self.open_level == self.closed_level:
            raise MbdError(f"open_level and closed_level are both {self.open_level}: they must differ")
        if not self.debounce >= 0.0 or not self.min_travel > 0.0:
            raise MbdError(f"debounce {self.debounce} s must be >= 0 and min_travel {self.min_travel} > 0")


@dataclass(frozen=True)
class GripperReading:
    """What a finger joint states.

    Attributes:
        events: openings and closings, alternating, in order.
        half_closings: (time of the deepest point [s], closure there) of each closing that turned back half way, or
            rested before that, as on an object much wider than the others.
        started_closed: the recording began with the gripper closed, so its first event is an opening.
    """

    events: tuple[GripperEvent, ...] = ()
    half_closings: tuple[tuple[float, float], ...] = ()
    started_closed: bool = False


def read_gripper(stamps: ArrayLike, joint: ArrayLike, config: FingerJointConfig | None = None) -> GripperReading:
    """Openings and closings of one recording.

    Args:
        stamps: (n,) [s], in any order; repeated stamps and NaN positions (dropouts) are left out.
        joint: (n,) positions of the finger joint, in any unit.
        config: thresholds and polarity.

    Returns:
        The events, each at the first sample beyond its threshold. None when the gripper never moved.

    Raises:
        MbdError: ``stamps`` and ``joint`` differ in shape.
    """
    config = config or FingerJointConfig()
    t, closure = _closures(stamps, joint, config)
    if t.size == 0:
        return GripperReading()
    events = []
    started_closed = closed = bool(np.median(closure[: _samples_held(t, config)]) >= 0.5)
    for i in range(t.size):
        crossed = closure[i] <= config.open_at if closed else closure[i] >= config.close_at
        if crossed and _lasts(t, closure, i, closed, config):
            events.append(GripperEvent(float(t[i]), GripperAction.OPEN if closed else GripperAction.CLOSE))
            closed = not closed
    return GripperReading(tuple(events), _half_closings(t, closure, events, started_closed, config), started_closed)


def _samples_held(t: NDArray[np.float64], config: FingerJointConfig) -> int:
    """How many samples in a row a level must hold to count: the debounce time, and three at any rate."""
    return max(3, round(config.debounce / float(np.median(np.diff(t)))) + 1)


def _lasts(
    t: NDArray[np.float64], closure: NDArray[np.float64], i: int, closed: bool, config: FingerJointConfig
) -> bool:
    """Whether the gripper stays beyond the threshold crossed at sample ``i``: most of the debounce time it is there.

    Where the recording ends before that time is over, all that is left of it must be beyond, two samples at least:
    who stops the recorder as the hand lets go has shown the opening.
    """
    # As many samples as that time usually holds: where some were lost, wild ones may be all that is left of it.
    enough = _samples_held(t, config)
    following = closure[i : max(i + enough, int(np.searchsorted(t, t[i] + config.debounce, side="right")))]
    if following.size < enough:
        beyond = following <= config.open_at if closed else following >= config.close_at
        return following.size > 1 and bool(beyond.all())
    level = float(np.median(following))
    return level <= config.open_at if closed else level >= config.close_at


def _half_closings(
    t: NDArray[np.float64],
    closure: NDArray[np.float64],
    events: list[GripperEvent],
    started_closed: bool,
    config: FingerJointConfig,
) -> tuple[tuple[float, float], ...]:
    """The deepest point of each closing without an event that came half way, or rested on its way."""
    found = []
    ends = [-np.inf, *(e.stamp for e in events), np.inf]
    for k, (start, end) in enumerate(pairwise(ends)):
        if started_closed == (k % 2 == 0):
            continue  # the gripper is closed between these two events
        begun = -1
        for i in np.flatnonzero((t > start) & (t < end)):
            if begun < 0 and closure[i] > config.open_at:
                begun = int(i)
            elif begun >= 0 and closure[i] < 0.5 * config.open_at:
                deepest = begun + int(np.argmax(closure[begun:i]))
                half_way = closure[deepest] >= 0.5 * (config.open_at + config.close_at)
                if t[i] - t[begun] > (config.debounce if half_way else RESTED):
                    found.append((float(t[deepest]), float(min(closure[deepest], 1.0))))
                begun = -1
    return tuple(found)


def _closures(
    stamps: ArrayLike, joint: ArrayLike, config: FingerJointConfig
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Usable samples in order of time as (stamps [s], closures); empty when the gripper never moved."""
    t, g = np.asarray(stamps, dtype=float), np.asarray(joint, dtype=float)
    if t.shape != g.shape or t.ndim != 1:
        raise MbdError(f"stamps of shape {t.shape} for joint positions of shape {g.shape}; expected (n,) for both")
    usable = np.isfinite(t) & np.isfinite(g)
    t, first = np.unique(t[usable], return_index=True)
    g = g[usable][first]
    if t.size < 2:
        return t[:0], g[:0]
    noise = _noise(g)
    # A single wild sample must neither stretch the range nor cross a threshold.
    padded = np.concatenate([g[:1], g, g[-1:]])
    g = np.median(np.stack([padded[:-2], padded[1:-1], padded[2:]]), axis=0)
    if not math.isnan(config.open_level):
        return t, (g - config.open_level) / (config.closed_level - config.open_level)
    # The ends of the range are levels held as long as a change must last: wild samples beside each other are not.
    windows = np.lib.stride_tricks.sliding_window_view(g, min(_samples_held(t, config), g.size))
    low, high = float(windows.max(axis=1).min()), float(windows.min(axis=1).max())
    # Noise has a range too: the hand moved only if the range is far beyond that.
    if high - low < max(config.min_travel, 8.0 * noise):
        return t[:0], g[:0]
    opened, closed = (low, high) if config.polarity is Polarity.LARGER_CLOSED else (high, low)
    return t, (g - opened) / (closed - opened)


def _noise(g: NDArray[np.float64]) -> float:
    """Standard deviation of a signal's noise [its unit], from what no straight line through three samples explains.

    So the fingers' own motion is no noise, be it most of a recording.
    """
    if g.size < 3:
        return 0.0
    bends = g[:-2] - 2.0 * g[1:-1] + g[2:]
    return 1.4826 * float(np.median(np.abs(bends))) / math.sqrt(6.0)
