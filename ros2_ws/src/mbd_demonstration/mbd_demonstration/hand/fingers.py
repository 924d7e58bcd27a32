"""Several fingers as one gripper position: a stuck, a lost or a mirrored finger must not hide what the others did."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

# A finger that goes less than this share of the farthest-going one's way is stuck (or a fixed tip).
STUCK = 0.1
# One with fewer finite values than this share of its samples is lost.
KNOWN = 0.5
# Fingers of one grasp correlate by at least so much, or against each other.
TOGETHER = 0.5
# Of a finger's values, those outside these quantiles may be wild.
INNER = (0.02, 0.98)
# A hand's joints, by the names that drivers give them; fixed or derived ones are told by that they never move.
FINGER_NAME = re.compile(r"finger|gripper|knuckle|jaw|thumb|claw", re.IGNORECASE)


@dataclass(frozen=True)
class CombinedFingers:
    """One gripper position of several fingers.

    Attributes:
        values: (n,) in the fingers' unit; NaN where no finger that counts is known.
        notes: what was left out or turned round, one sentence each.
    """

    values: Floats
    notes: tuple[str, ...] = ()


def combined(fingers: Mapping[str, ArrayLike]) -> CombinedFingers:
    """The mean of the fingers that move, each sample over the same set of fingers.

    A finger that never moves while others do, or is mostly NaN, is left out; one that moves against the first (a
    mirrored or mimic joint of the other sign) is turned round; where one is lost for a while, it is taken to go on
    as it went with the others, so that losing it makes no step in the mean.

    Args:
        fingers: (n,) positions of each, by name, all in one unit.

    Raises:
        MbdError: there is no finger, or they differ in length.
    """
    names = tuple(fingers)
    table = [np.asarray(fingers[name], dtype=float) for name in names]
    if not table or any(column.shape != table[0].shape or column.ndim != 1 for column in table):
        raise MbdError(f"fingers {names} of shapes {[c.shape for c in table]}; expected (n,) for each, the same n")
    if len(table) == 1:
        return CombinedFingers(table[0])
    notes = []
    known = [float(np.isfinite(column).mean()) if column.size else 0.0 for column in table]
    usable = [k for k in range(len(table)) if known[k] >= KNOWN] or [int(np.argmax(known))]
    for k in set(range(len(table))) - set(usable):
        notes.append(f"finger '{names[k]}' is left out: {1.0 - known[k]:.0%} of its samples are no number")
    ways = {k: _way(table[k]) for k in usable}
    farthest = max(ways.values())
    moving = [k for k in usable if ways[k] >= STUCK * farthest]
    for k in set(usable) - set(moving):
        notes.append(f"finger '{names[k]}' is left out: it stayed at {np.nanmedian(table[k]):.3g} while others moved")
    first = table[moving[0]]
    kept = []
    for k in moving:
        column = table[k]
        together = _together(first, column)
        if abs(together) < TOGETHER:
            notes.append(
                f"fingers '{names[k]}' and '{names[moving[0]]}' do not move together (correlation {together:.1f}): "
                "if they are no parts of one grasp, name those that are"
            )
        if together < 0.0:
            notes.append(f"finger '{names[k]}' moves against '{names[moving[0]]}': turned round")
            column = -column
        kept.append(column)
    return CombinedFingers(np.mean(_filled(kept), axis=0), tuple(notes))


def _way(column: Floats) -> float:
    """How far a finger went, wild values aside."""
    low, high = np.nanquantile(column, INNER)
    return float(high - low)


def _together(first: Floats, other: Floats) -> float:
    """Correlation of two fingers where both are known; 1 where that is nowhere."""
    both = np.isfinite(first) & np.isfinite(other)
    if first is other or both.sum() < 3:
        return 1.0
    a, b = first[both] - first[both].mean(), other[both] - other[both].mean()
    spread = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / spread if spread > 0.0 else 1.0


def _filled(columns: Sequence[Floats]) -> list[Floats]:
    """Each column with its gaps filled by what the line through it and the first other known one gives there."""
    filled = []
    for k, column in enumerate(columns):
        full = column.copy()
        for j, other in enumerate(columns):
            gaps = ~np.isfinite(full) & np.isfinite(other)
            both = np.isfinite(column) & np.isfinite(other)
            if j == k or not gaps.any() or both.sum() < 3:
                continue
            slope, offset = np.polyfit(other[both], column[both], 1)
            full[gaps] = slope * other[gaps] + offset
        filled.append(full)
    return filled


def resampled(
    series: Mapping[str, tuple[ArrayLike, ArrayLike]], longest_gap: float
) -> tuple[Floats, dict[str, Floats]]:
    """Fingers that came in separate messages, at the stamps of the one that came most often.

    Args:
        series: (stamps [s], positions) of each finger, (n_k,) both, by name.
        longest_gap: [s] between samples of a finger over more than this it is not known.

    Returns:
        (stamps (n,), positions (n,) of each finger by name), in the order of arrival where all came together.
    """
    arrays = {name: (np.asarray(t, dtype=float), np.asarray(p, dtype=float)) for name, (t, p) in series.items()}
    base = max(arrays.values(), key=lambda entry: entry[0].size)[0]
    made = {}
    for name, (t, p) in arrays.items():
        if t.shape == base.shape and np.array_equal(t, base, equal_nan=True):
            made[name] = p
            continue
        finite = np.isfinite(t) & np.isfinite(p)
        order = np.argsort(t[finite], kind="stable")
        at, value = t[finite][order], p[finite][order]
        if at.size < 2:
            made[name] = np.full(base.shape, np.nan)
            continue
        after = np.clip(np.searchsorted(at, base), 1, at.size - 1)
        known = (
            (at[after] - at[after - 1] <= longest_gap) & (base >= at[0] - longest_gap) & (base <= at[-1] + longest_gap)
        )
        made[name] = np.where(known, np.interp(base, at, value), np.nan)
    return base, made


def named_fingers(names: Sequence[str], wanted: Sequence[str]) -> tuple[str, ...]:
    """The finger joints among a message's names: those wanted, with or without a robot's prefix, else by pattern.

    Args:
        names: of the joints in a message.
        wanted: the parameter's names.

    Returns:
        Names as in the message, each once. By pattern only where none of the wanted ones is there.
    """
    found = [name for want in wanted for name in names if name == want]
    found = found or [name for want in wanted for name in names if _same_but_prefix(name, want)]
    return tuple(dict.fromkeys(found or [name for name in names if FINGER_NAME.search(name)]))


def _same_but_prefix(name: str, want: str) -> bool:
    longer, shorter = (name, want) if len(name) > len(want) else (want, name)
    return bool(shorter) and longer.endswith(shorter) and longer[-len(shorter) - 1] in "_/-." and "_" in shorter


def hands(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """The finger joints by the hand they belong to: by what stands before the word for a finger in their names."""
    found: dict[str, list[str]] = {}
    for name in names:
        match = FINGER_NAME.search(name)
        head = name[: match.start()] if match else ""
        # A side is part of one hand with two fingers, unless it stands before the arm: left_finger, left_arm_finger.
        head = re.sub(r"(left|right|inner|outer|[lr])_(inner_|outer_)?$", "", head)
        found.setdefault(head, []).append(name)
    return {head: tuple(joints) for head, joints in found.items()}
