"""When a spoken gripper command was carried out: people say it up to two seconds late or early."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mbd_demonstration.clocks.skew import RESTS, SMALLEST, STEP, speeds
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.trajectory import ToolTrajectory

Floats = NDArray[np.float64]

# Words come so late or early [s].
WORDS_OFF = 2.0
# A rest shorter than this is a turn between two ways, not an act [s], unless the tool came down to it and goes up again
# by so much [m] within the other time [s].
IN_PASSING, DIP, DIP_WITHIN = 0.5, 0.02, 0.7
# An object is taken again where it was let go, this near [m].
NEAR_LET_GO = 0.1
# What a reading of the words costs, in seconds by which they would be off: one dated in passing, in motion, in the rest
# of the word before (a hand rarely lets go where it grasped), against their order; and a finger's event, by its share.
PASSING, MOVING, SAME_REST, DISORDER, FINGERS = 2.0, 2.5, 1.0, 50.0, 0.1


@dataclasses.dataclass(frozen=True)
class WordDate:
    """When a word may have been carried out.

    Attributes:
        stamp: [s].
        cost: see PASSING.
        rest: number of the tool's rest it lies in; -1: in none.
        by: what dates it; empty: it stays as stamped.
    """

    stamp: float
    cost: float
    rest: int = -1
    by: str = ""


def words_dated(
    words: Sequence[GripperEvent],
    trajectory: ToolTrajectory,
    fingers: Sequence[GripperEvent] = (),
    near_object: Callable[[float], bool] | None = None,
) -> tuple[tuple[GripperEvent, ...], tuple[str, ...]]:
    """Spoken gripper commands where they were carried out, and a sentence for each that was moved.

    Each is dated as it is stamped, by the fingers' own event of that kind within two seconds, or by a rest of the tool
    within two seconds (of a closing: one near an object, or near where one was let go); of all readings in order, the
    one that moves them least, and in which the tool rests and goes on between two words.

    Args:
        words: as stamped, in order.
        trajectory: path of the tool.
        fingers: what the finger joint shows, if it is known.
        near_object: whether the tool is near an object of the source scene at a time [s]; None: not known.
    """
    runs = _rests(trajectory)
    let_go: list[Floats] = []
    options = []
    for word in words:
        places = tuple(let_go)

        def fits(stamp: float, word: GripperEvent = word, places: Sequence[Floats] = places) -> bool:
            if word.action is GripperAction.OPEN or near_object is None or near_object(stamp):
                return True
            here = trajectory.pose_at(stamp).position
            return any(float(np.linalg.norm(here - there)) <= NEAR_LET_GO for there in places)

        found = _dates(word, runs, fingers, fits)
        options.append(found)
        if word.action is GripperAction.OPEN:
            let_go += [trajectory.pose_at(option.stamp).position for option in found if option.rest >= 0]
    dated: list[GripperEvent] = []
    notes = []
    for word, date in zip(words, _cheapest(options), strict=True):
        at = max(date.stamp, dated[-1].stamp) if dated else date.stamp
        if date.by and abs(at - word.stamp) > SMALLEST:
            verb = "close" if word.action is GripperAction.CLOSE else "open"
            notes.append(
                f"at {word.stamp - float(trajectory.stamps[0]):.1f} s '{verb}' was said "
                f"{abs(at - word.stamp):.1f} s {'late' if at < word.stamp else 'early'}: dated by {date.by}"
            )
        dated.append(dataclasses.replace(word, stamp=at))
    return tuple(dated), tuple(notes)


def _rests(trajectory: ToolTrajectory) -> list[tuple[float, float, bool]]:
    """(begin, end [s], whether only in passing) of each stretch in which the tool rests."""
    grid, speed = speeds(trajectory)
    at = np.flatnonzero(speed <= RESTS)
    runs = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size else []
    found = []
    for run in runs:
        begin, end = float(grid[run[0]]), float(grid[run[-1]])
        around = (begin - DIP_WITHIN, 0.5 * (begin + end), end + DIP_WITHIN)
        before, here, after = (float(trajectory.pose_at(stamp).position[2]) for stamp in around)
        found.append((begin, end, end - begin < IN_PASSING and min(before, after) - here < DIP))
    return found


def _dates(
    word: GripperEvent,
    runs: Sequence[tuple[float, float, bool]],
    fingers: Sequence[GripperEvent],
    fits: Callable[[float], bool],
) -> list[WordDate]:
    """All times at which a word may have been carried out."""
    found = []
    near = [e.stamp for e in fingers if e.action is word.action and abs(e.stamp - word.stamp) <= WORDS_OFF]
    for number, (begin, end, passing) in enumerate(runs):
        # A little inside the rest: at its very edge the tool still arrives, or already leaves.
        inset = min(2 * STEP, (end - begin) / 2)
        at = word.stamp if begin <= word.stamp <= end else min(max(word.stamp, begin + inset), end - inset)
        if abs(at - word.stamp) > WORDS_OFF or not fits(at):
            continue
        cost = abs(at - word.stamp) + (PASSING if passing else 0.0)
        if near and not any(begin - STEP <= stamp <= end + STEP for stamp in near):
            cost += MOVING  # the fingers did it elsewhere
        found.append(WordDate(at, cost, number, "the rest of the tool" if at != word.stamp else ""))
    for stamp in near:
        number = next((k for k, (begin, end, _) in enumerate(runs) if begin - STEP <= stamp <= end + STEP), -1)
        found.append(WordDate(stamp, STEP + FINGERS * abs(stamp - word.stamp), number, "the fingers"))
    return [*found, WordDate(word.stamp, MOVING)]


def _cheapest(options: Sequence[Sequence[WordDate]]) -> list[WordDate]:
    """One date of each word: those that cost least together."""
    total: list[list[float]] = []
    back: list[list[int]] = []
    for k, dates in enumerate(options):
        total.append([])
        back.append([])
        for date in dates:
            if not k:
                total[k].append(date.cost)
                back[k].append(-1)
                continue
            known = zip(total[k - 1], options[k - 1], strict=True)
            costs = [before + _step(earlier, date) for before, earlier in known]
            best = min(range(len(costs)), key=costs.__getitem__)
            total[k].append(costs[best] + date.cost)
            back[k].append(best)
    chosen: list[WordDate] = []
    at = min(range(len(total[-1])), key=total[-1].__getitem__) if total else -1
    for k in reversed(range(len(options))):
        chosen.append(options[k][at])
        at = back[k][at]
    return chosen[::-1]


def _step(earlier: WordDate, later: WordDate) -> float:
    """What it costs that one word is dated after another."""
    if later.stamp < earlier.stamp:
        return DISORDER * (1.0 - math.exp(later.stamp - earlier.stamp))
    return SAME_REST if later.rest == earlier.rest >= 0 and not (later.by == earlier.by == "the fingers") else 0.0
