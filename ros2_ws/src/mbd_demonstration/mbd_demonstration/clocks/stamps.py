"""What is wrong with the stamps of a recording, told with the numbers; mended only where the order is certain.

Samples are known in the order they arrived. Within a few sampling intervals that may differ from the order of their
stamps; beyond that a clock was set, restarted or stood still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

# Out of order by so much is normal: the larger of a time [s] and a number of sampling intervals.
LATE, LATE_SAMPLES = 1.0, 5.0
# No pause within a demonstration is this long [s]; a clock that was set to the date jumps by 50 years.
LONGEST_PAUSE = 86400.0
# Stamps since boot or since 1970: a sample stamped below this among others above that has none [s].
NONE_BELOW, DATE_ABOVE = 1e-9, 1e6
# More jumps back than this are rows that somebody mixed, not clocks that were restarted.
MOST_RESTARTS = 5
# A clock set back by so many sampling intervals is told from samples that overtook each other by this share of the
# samples that should be there twice.
SET_BACK_SAMPLES, TWICE = 3.5, 0.6
# A longer pause [s] is told: it may be a clock that was set forward.
LONG_PAUSE = 120.0
# So many equal stamps one after the other are a clock that stood still; how far the rate may be off that dates them.
STOOD_STILL, STEADY = 3, 0.25
# A stream whose values stand still for so long [s], and then go on somewhere else, was held by its driver.
HELD, HELD_JUMP = 1.0, 5.0


@dataclass(frozen=True)
class CheckedStamps:
    """Stamps that can be sorted.

    Attributes:
        stamps: (n,) [s] in order of arrival; NaN for samples that cannot be dated.
        notes: what was noticed, with the number, and what was done, one sentence each.
    """

    stamps: Floats
    notes: tuple[str, ...] = ()


def checked(stamps: ArrayLike, what: str, arrivals: ArrayLike | None = None) -> CheckedStamps:
    """Look at the stamps of one stream.

    Args:
        stamps: (n,) [s] in order of arrival.
        what: the stream's name, for the notes.
        arrivals: (n,) [s] when each arrived, by a clock that never jumps; None where that is not known, as in files.

    After a clock was set back or forward the samples go on from where they were: by the time between arrivals where
    that is known, else one sampling interval later, as a file keeps the order and nothing of the pause.
    """
    t = np.array(stamps, dtype=float)
    notes: list[str] = []
    finite = np.isfinite(t)
    zero = finite & (np.abs(t) < NONE_BELOW)
    if zero.any() and finite.any() and float(np.median(t[finite])) > DATE_ABOVE:
        notes.append(f"{int(zero.sum())} of {t.size} stamps of {what} are zero among dates: those samples are left out")
        t[zero] = np.nan
        finite = np.isfinite(t)
    index = np.flatnonzero(finite)
    if index.size < 3:
        return CheckedStamps(t, tuple(notes))
    at = t[index]
    spacing = _spacing(at)
    jumps = _jumps(at, max(LATE, LATE_SAMPLES * spacing)) or _small_steps_back(at, spacing)
    if len(jumps) > MOST_RESTARTS:
        return CheckedStamps(t, (*notes, *_unsorted(at, what, 0.0)))
    clock = None if arrivals is None else np.asarray(arrivals, dtype=float)[index]
    for jump in jumps:
        back = float(at[jump - 1] - at[jump])
        pause = spacing if clock is None else max(float(clock[jump] - clock[jump - 1]), spacing)
        by = back + pause
        way = f"went back by {by:.3g} s" if by > 0.0 else f"went forward by {-by:.3g} s"
        known = f"{pause:.2g} s after" if clock is not None else "right after (how long the pause was is not known)"
        notes.append(
            f"the stamps of {what} {way} at sample {index[jump] + 1} of {t.size}: that clock was set or restarted; "
            f"what follows is taken as {known} what came before"
        )
        at[jump:] += by
    notes += _stood_still(at, index, spacing, what)
    pauses = np.diff(at, prepend=at[0])
    notes += [
        f"{what}: nothing for {pauses[k]:.3g} s before sample {index[k] + 1} of {t.size}: a pause, or a clock that was "
        "set forward; the times are left as they are"
        for k in np.flatnonzero(pauses > LONG_PAUSE)[:MOST_RESTARTS]
    ]
    t[index] = at
    return CheckedStamps(t, (*notes, *_unsorted(at, what, max(LATE, LATE_SAMPLES * spacing))))


def _unsorted(at: Floats, what: str, late: float) -> tuple[str, ...]:
    """A sentence where samples came later than ``late`` [s] after ones with later stamps."""
    by = float((np.maximum.accumulate(at) - at).max())
    if by <= late:
        return ()
    back = int((np.diff(at) < 0.0).sum())
    return (
        f"{what}: {back} of {at.size} samples are not in order of time (by up to {by:.3g} s): sorted by their stamps",
    )


def _spacing(at: Floats) -> float:
    """Median time between stamps [s], repeated ones aside: as they came, or of mixed rows as they are sorted."""
    steps = np.diff(at)
    if int((steps < 0.0).sum()) > MOST_RESTARTS:
        steps = np.diff(np.unique(at))
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if steps.size else 0.0


def _jumps(at: Floats, late: float) -> list[int]:
    """Samples from which on the clock is another: far back from all before, or a day ahead, and it stays so."""
    found = []
    begin = 0
    for k in np.flatnonzero((np.diff(at) < -late) | (np.diff(at) > LONGEST_PAUSE)) + 1:
        ahead = at[k] - at[k - 1] > LONGEST_PAUSE
        back = at[begin:k].max() - at[k] > late
        if ahead or back:
            found.append(int(k))
            begin = int(k)
    return found


def _small_steps_back(at: Floats, spacing: float) -> list[int]:
    """Samples from which on the clock is a little behind: the times from there on were there before, and come again."""
    found: list[int] = []
    backward = np.flatnonzero(np.diff(at) < 0.0) + 1
    if backward.size > MOST_RESTARTS or not spacing:
        return found
    begin = 0
    for k in backward.tolist():
        before, after = at[begin:k], at[k:]
        top = float(before.max())
        expected = (top - float(at[k])) / spacing
        if expected <= SET_BACK_SAMPLES:
            continue
        again = after[: round(expected)]
        twice = int((before >= at[k] - 0.5 * spacing).sum()) >= TWICE * expected
        goes_on = again.size >= 3 and (np.diff(again) > 0.0).all() and again[-1] <= top + spacing
        if twice and goes_on:
            found.append(k)
            begin = k
    return found


def _stood_still(at: Floats, index: NDArray[np.intp], spacing: float, what: str) -> list[str]:
    """A sentence for each run of equal stamps; ``at`` (n,) is changed where a steady rate makes their times certain.

    ``index`` (n,) says which samples of the stream they are.
    """
    edges = np.flatnonzero(np.diff(at, prepend=np.nan, append=np.nan) != 0.0)
    notes = []
    for first, after in pairwise(edges.tolist()):
        equal = after - first
        if equal < STOOD_STILL:
            continue
        sentence = f"{what}: {equal} samples from sample {index[first] + 1} on have the same stamp"
        lasts = float(at[after] - at[first]) if after < at.size else 0.0
        if lasts > 0.0 and abs(lasts - equal * spacing) <= max(STEADY * equal * spacing, spacing):
            at[first:after] += np.arange(equal) * lasts / equal
            notes.append(f"{sentence}: by the steady rate they came over {lasts:.2g} s, and are taken so")
        else:
            notes.append(f"{sentence}: when they came is not certain, so all but the first are left out")
    return list(joined(notes))


def held(stamps: ArrayLike, values: ArrayLike, what: str) -> tuple[str, ...]:
    """A sentence for each time that a stream repeated one value and then was somewhere else.

    Args:
        stamps: (n,) [s], increasing.
        values: (n, d), such as positions (3) [m].
        what: the stream's name.

    A hand that rests gives equal values too, where there is no noise; but it goes on from where it rested.
    """
    t, p = np.asarray(stamps, dtype=float), np.asarray(values, dtype=float)
    if t.size < 5:
        return ()
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
    moving = steps[steps > 0.0]
    if not moving.size or float((steps == 0.0).mean()) > 0.5:
        return ()  # a driver that repeats all values until it has new ones
    usual = float(np.quantile(moving, 0.95))
    changes = np.concatenate([[-1], np.flatnonzero(steps > 0.0)]) + 1
    notes = []
    for first, after in pairwise(changes.tolist()):
        lasted = float(t[after - 1] - t[first])
        if lasted >= HELD and steps[after - 1] > HELD_JUMP * usual:
            notes.append(
                f"{what} repeated one value for {lasted:.1f} s from {t[first] - t[0]:.1f} s on and then was "
                f"{steps[after - 1]:.3g} away: held by its driver; where the tool was meanwhile is not known"
            )
    return tuple(notes)


def joined(notes: Sequence[str], most: int = 5) -> tuple[str, ...]:
    """At most so many notes, and how many more there were."""
    kept = tuple(dict.fromkeys(notes))
    return kept if len(kept) <= most else (*kept[:most], f"and {len(kept) - most} more of that kind")
