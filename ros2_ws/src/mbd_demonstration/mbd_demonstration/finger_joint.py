"""Gripper events from the position of a finger joint: one for each closing and opening of the hand.

The joint goes from one level to another, rests there, and comes back. A turn of at least a share of the range it went
through is an act of the hand, whatever hand, unit and object it was; the hand's levels need not be known. A closing
is dated when the fingers reach the level at which they then rest (the hand holds), an opening when they leave it (the
hand lets go): the tool's pose at that time is the pose of the grasp and of the release, however slowly fingers move.
The same function serves recorded files and the live node, which calls it on what it has recorded so far.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import ArrayLike

from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.hand.finger_signal import SPARSE, FingerSignal, finger_signal
from mbd_demonstration.hand.turns import GIVING, Crest, Floats, crests, rest_at, turns

# Noise alone goes through this many of its standard deviations in an hour of samples, with a margin.
MOVED = 10.0
DRIFTS = 6.0  # and through this many within a second
BEGIN = 0.5  # [s] of a recording that show whether it begins open
COARSE = 0.05  # share of the range in which a joint is read at most
TELLING = 0.1  # share of the range by which closings differ when one held something and another less
# Without a rest, a closing by less than this share in the midst of an opening is none, nor is an opening right after a
# closing one: the fingers went past where they then stay.
IN_PASSING = 0.35
CLOSED = 0.5  # a recording that begins closed by more than this share of the range began with the gripper closed
BEGINS_CLOSED = (
    "the fingers begin at their closed end; if the hand was open there, larger numbers mean the other thing: "
    "{} (finger_polarity, --polarity)"
)


class FingerConfigError(MbdError):
    """A setting of the finger joint that cannot work."""


class Polarity(StrEnum):
    """Which way the joint's numbers go; given levels say it too."""

    LARGER_CLOSED = "larger_closed"
    LARGER_OPEN = "larger_open"


@dataclass(frozen=True)
class FingerJointConfig:
    """How closings are read off a finger joint.

    Attributes:
        polarity: which way the joint's numbers go.
        open_level, closed_level: joint positions of the open and the closed hand; they say the polarity, unless
            the recording then begins closed. NaN: unknown.
        min_turn: share of the recorded range that the fingers must go, and come back, to have closed and opened:
            fingers that give way or sag while the hand travels go less.
        deep: a closing by this share of the range counts however short; a shallower one if the fingers rest there.
        rest: [s] so long, and two sampling intervals (one above 0.3 s) more; a hand that turns back at once took hold
            of nothing.
        settle: share of a turn within which the fingers have arrived at its level; at least three times the noise.
        debounce: [s] a change must last; shorter ones are glitches of the joint or of the bus.
        min_travel: [joint unit] a gripper whose recorded range is smaller never moved.
    """

    polarity: Polarity = Polarity.LARGER_CLOSED
    open_level: float = math.nan
    closed_level: float = math.nan
    min_turn: float = 0.15
    deep: float = 0.65
    rest: float = 0.4
    settle: float = 0.02
    debounce: float = 0.1
    min_travel: float = 0.005

    def __post_init__(self) -> None:
        """Validate once; raises FingerConfigError naming the field."""
        for name, low, high in (("min_turn", 0.0, 1.0), ("deep", 0.0, 1.0), ("settle", 0.0, 0.5)):
            if not low < getattr(self, name) <= high:
                raise FingerConfigError(
                    f"{name} is {getattr(self, name)}; expected a share above {low:g}, up to {high:g}"
                )
        if math.isnan(self.open_level) != math.isnan(self.closed_level):
            raise FingerConfigError(
                f"open_level {self.open_level} and closed_level {self.closed_level}: give both, or NaN for both"
            )
        if self.open_level == self.closed_level:
            raise FingerConfigError(f"open_level and closed_level are both {self.open_level}: they must differ")
        if not self.debounce >= 0.0 or not self.rest >= 0.0 or not self.min_travel > 0.0:
            raise FingerConfigError(
                f"debounce {self.debounce} s and rest {self.rest} s must be >= 0, min_travel {self.min_travel} > 0"
            )

    @property
    def stated_sign(self) -> float:
        """The same by the polarity alone."""
        return 1.0 if self.polarity is Polarity.LARGER_CLOSED else -1.0

    @property
    def sign(self) -> float:
        """+1 where larger numbers are more closed, else -1."""
        if math.isnan(self.open_level):
            return self.stated_sign
        return 1.0 if self.closed_level > self.open_level else -1.0


@dataclass(frozen=True)
class GripperReading:
    """What a finger joint states.

    Attributes:
        events: openings and closings, alternating, in order.
        half_closings: (time of the deepest point [s], its share of the range) of each closing that turned back before
            it was deep, without a rest.
        started_closed: the recording began with the gripper closed, so its first event is an opening.
        spacing: median time between samples [s]: no event is known better.
        notes: what was noticed about the recording and its settings, one sentence each.
    """

    events: tuple[GripperEvent, ...] = ()
    half_closings: tuple[tuple[float, float], ...] = ()
    started_closed: bool = False
    spacing: float = 0.0
    notes: tuple[str, ...] = ()


def read_gripper(stamps: ArrayLike, joint: ArrayLike, config: FingerJointConfig | None = None) -> GripperReading:
    """Openings and closings of one recording.

    Args:
        stamps: (n,) [s], in any order; repeated stamps and NaN positions (dropouts) are left out.
        joint: (n,) positions of the finger joint, in any unit.
        config: polarity and what counts as a turn.

    Returns:
        The events: closings as the hand holds, openings as it lets go. None when the gripper never moved.

    Raises:
        MbdError: ``stamps`` and ``joint`` differ in shape.
    """
    config = config or FingerJointConfig()
    signal = finger_signal(stamps, joint, config.debounce)
    if signal.values.size < 2:
        return GripperReading(spacing=signal.spacing)
    slowly: tuple[str, ...] = ()
    if signal.spacing > SPARSE:
        slowly = (f"the gripper was sampled every {signal.spacing:.2g} s only: its events are known no better",)
    low, high = signal.held_range
    span = high - low
    # Noise has a range too: the hand moved only if the range is far beyond that.
    # So has what it rounds to, by a step more.
    if span < max(config.min_travel, MOVED * signal.noise + min(signal.quantum, MOVED * signal.noise)):
        return GripperReading(spacing=signal.spacing, notes=slowly)
    fastest = signal.fastest
    if fastest < GIVING * span + DRIFTS * signal.noise:
        note = (
            f"the fingers go through {span:.3g} but by {fastest:.2g} a second at most: taken as drift, not as acts of "
            "the hand (are the recording's times in seconds?)"
        )
        return GripperReading(spacing=signal.spacing, notes=(*slowly, note))
    sign, contradiction = _direction(signal, config, 0.5 * (low + high))
    bottom = low if sign > 0 else -high
    closure = (sign * signal.values - bottom) / span
    light = (sign * signal.light - bottom) / span
    # A joint is read in steps; what goes further at once is a hand that moves between two samples.
    noise = max(signal.noise, min(signal.quantum, COARSE * span) / 3.0) / span
    events, half, started = _events(signal.stamps, closure, light, noise, config)
    began = (BEGINS_CLOSED.format(Polarity.LARGER_OPEN if sign > 0 else Polarity.LARGER_CLOSED),) if started else ()
    return GripperReading(tuple(events), tuple(half), started, signal.spacing, (*slowly, *contradiction, *began))


def _direction(signal: FingerSignal, config: FingerJointConfig, middle: float) -> tuple[float, tuple[str, ...]]:
    """(+1 where larger is more closed, else -1; a sentence where levels and polarity say different things).

    Levels must not make it worse: of the two that is taken by which the recording begins open, ``middle`` being half
    way.
    """
    if config.sign == config.stated_sign:
        return config.sign, ()
    first = signal.values[signal.stamps <= signal.stamps[0] + BEGIN]
    by_levels = config.sign * (float(np.median(first)) - middle) <= 0.0
    taken = "levels" if by_levels else "polarity"
    note = (
        f"the levels {config.open_level:g} (open) and {config.closed_level:g} (closed) contradict the polarity "
        f"{config.polarity}: the one by which the "
        f"recording begins open, the {taken}, is followed; give both alike"
    )
    return (config.sign if by_levels else config.stated_sign), (note,)


def _events(
    stamps: Floats, closure: Floats, light: Floats, noise: float, config: FingerJointConfig
) -> tuple[list[GripperEvent], list[tuple[float, float]], bool]:
    """(events, half closings, began closed) of a closure (n,) that goes through 0..1; ``light`` as in FingerSignal."""
    found, half = _acts(stamps, closure, light, noise, config)
    if not found:
        return [], half, False
    started = not found[0].rises and float(np.median(closure[: found[0].peak + 1])) >= CLOSED
    spacing = float(np.median(np.diff(stamps)))
    unsure = spacing if spacing > SPARSE else 0.0
    events: list[GripperEvent] = []
    rests = [rest_at(stamps, closure, crest, settle=config.settle, noise=noise) for crest in found]
    heights = [rest.height for rest in rests]
    # Without a shallower closing beside it nothing shows how far the hand could have closed.
    telling = max(heights) - min(heights) >= TELLING
    for crest, rest in zip(found, rests, strict=True):
        if crest.rises:
            level = rest.height if telling else math.nan
            at, since = float(stamps[rest.first]), float(stamps[rest.slow])
            events.append(GripperEvent(at, GripperAction.CLOSE, max(unsure, at - since), level))
        if crest.falls and (crest.rises or started):
            events.append(GripperEvent(float(stamps[rest.last]), GripperAction.OPEN, unsure))
    return events, half, started


def _acts(
    stamps: Floats, closure: Floats, light: Floats, noise: float, config: FingerJointConfig
) -> tuple[list[Crest], list[tuple[float, float]]]:
    """(the crests that are acts of the hand, half closings); arguments as in ``_events``."""
    found = crests(turns(closure, max(config.min_turn, 8.0 * noise)), closure.size)
    half: list[tuple[float, float]] = []
    spacing = float(np.median(np.diff(stamps)))
    # A turn can put two equal samples on its sides, never three in a row so far apart.
    least = config.rest + (spacing if spacing > SPARSE else 2.0 * spacing)
    place = 0
    while place < len(found):
        crest = found[place]
        rest = rest_at(stamps, closure, crest, settle=config.settle, noise=noise)
        if not (crest.rises and crest.falls) or rest.lasts >= least:
            place += 1
            continue
        rise, fall = crest.ways(closure)
        if rest.height < config.deep or rise < min(IN_PASSING, fall):
            deepest = rest.first + int(np.argmax(light[rest.first : rest.last + 1]))
            half.append((float(stamps[deepest]), float(min(light[deepest], 1.0))))
            del found[place]
        elif fall < IN_PASSING and place + 1 < len(found):
            found[place + 1] = replace(found[place + 1], begin=crest.begin)
            del found[place]
        elif fall < IN_PASSING:
            found[place] = replace(crest, end=closure.size - 1, falls=False)
        else:
            place += 1
    return found, half
