"""What a participant shows, and what he means when he answers: the task's script with his slips in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from mbd_cell.layout.placement import MAX_REACH, REGION, RESERVED_GAP, layout
from mbd_cell.layout.scenes import Arrangement, DemonstratedStep, TaskScenes
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.task import StepKind

from mbd_experiments.simulated_participants.error_model import Intention, Slip

SCRIPT_STREAM = 11  # of chance, apart from those of the cell
# Measured: as high as the hand passes over the tower of the stacking task, 0.364 m, it reaches 0.625 m from the arm's
# base; it trembles by 4 mm, and what it holds need not hang exactly below it.
TOWER_REACH = 0.61  # [m]
GRID = 0.02  # [m] between places tried for an object put aside
FIXED_ASIDE = (0.33, 0.31)  # where a scattered layout, made afterwards, keeps a place free


@dataclass(frozen=True)
class ParticipantScript:
    """One participant's session.

    Attributes:
        scenes: with the steps he shows.
        asked: the (picked, placed onto) pairs he was asked for.
        meant: for each step shown, the source object he thinks it is about when he answers.
        preference: right target names by source name, the one he would give first first.
        repeats: he gives the object of the answer before once more, once.
    """

    scenes: TaskScenes
    asked: tuple[tuple[str, str], ...]
    meant: tuple[str, ...]
    preference: Mapping[str, tuple[str, ...]]
    repeats: bool


def pairs_of(steps: Sequence[DemonstratedStep]) -> tuple[tuple[str, str], ...]:
    """(picked, placed onto) of each place; what is put on the table is placed onto itself."""
    return tuple((s.picked, s.onto or s.picked) for s in steps if s.kind is StepKind.PLACE)


def participant_script(scenes: TaskScenes, intention: Intention, laid_by: int | None = None) -> ParticipantScript:
    """The script of one participant, from his seed.

    Args:
        scenes: of the task.
        intention: what he gets wrong.
        laid_by: seed by which the table is laid that he puts things aside on; None: his own.

    Raises:
        MbdError: there is no free place for an object he puts aside.
    """
    rng = np.random.default_rng([intention.seed, SCRIPT_STREAM])
    asked = pairs_of(scenes.steps)
    steps, meant = scenes.steps, [name for pair in asked for name in pair]
    if Slip.WRONG_OBJECT in intention.slips:
        steps = _exchanged(steps, *_two_of(asked, rng))
    if Slip.WRONG_ORDER in intention.slips:
        meant = _reordered(asked, *_two_of(asked, rng))
    thing = _put_down_first(intention.slips, asked, rng)
    if thing:
        table = intention.seed if laid_by is None else laid_by
        aside = _put_aside(replace(scenes, steps=steps), thing, table)
        first = next(k for k, s in enumerate(steps) if thing in (s.picked, s.onto)) // 2 * 2
        steps = (*steps[:first], *aside, *steps[first:])
        meant = [*meant[:first], thing, thing, *meant[first:]]
    preference = {
        name: tuple(right[int(k)] for k in rng.permutation(len(right))) for name, right in scenes.solution.items()
    }
    return ParticipantScript(
        replace(scenes, steps=tuple(steps)), asked, tuple(meant), preference, Slip.REPEATED in intention.slips
    )


def _two_of(asked: Sequence[tuple[str, str]], rng: np.random.Generator) -> tuple[str, str]:
    """Two objects picked one after the other."""
    first = int(rng.integers(len(asked) - 1))
    return asked[first][0], asked[first + 1][0]


def _exchanged(steps: Sequence[DemonstratedStep], one: str, other: str) -> tuple[DemonstratedStep, ...]:
    """The steps with one object taken for the other throughout."""
    name = {one: other, other: one}
    return tuple(
        replace(s, picked=name.get(s.picked, s.picked), onto=name.get(s.onto, s.onto) if s.onto else None)
        for s in steps
    )


def _reordered(asked: Sequence[tuple[str, str]], one: str, other: str) -> list[str]:
    """Objects meant step by step when those two come in the other's turn, with their places if these are their own."""
    order = [picked for picked, _ in asked]
    shared = len({onto for _, onto in asked}) < len(asked) or any(onto in order for _, onto in asked)
    exchange = {one: other, other: one}
    onto_of = dict(asked)
    meant = []
    for picked, onto in asked:
        thought = exchange.get(picked, picked)
        meant += [thought, onto if shared else onto_of[thought]]
    return meant


def _put_down_first(slips: Sequence[Slip], asked: Sequence[tuple[str, str]], rng: np.random.Generator) -> str:
    """Which object is first put elsewhere on the table, "" for none."""
    if Slip.MOVED_STACK in slips:
        picked = {name for name, _ in asked}
        # What is placed onto and never picked up itself: the base of a stack, or a bowl.
        bases = [onto for _, onto in asked if onto not in picked]
        return bases[int(rng.integers(len(bases)))]
    if Slip.PUT_ASIDE in slips:
        return asked[int(rng.integers(len(asked)))][0]
    return ""


def _put_aside(scenes: TaskScenes, name: str, seed: int) -> tuple[DemonstratedStep, DemonstratedStep]:
    """Pick an object up and put it on a free place of the table."""
    place = FIXED_ASIDE if scenes.arrangement is Arrangement.SCATTERED else _free_place(scenes, name, seed)
    return DemonstratedStep(StepKind.PICK, name), DemonstratedStep(StepKind.PLACE, name, None, place)


def _free_place(scenes: TaskScenes, name: str, seed: int) -> tuple[float, float]:
    """The place farthest from all other outlines, of those in reach (x, y) [m]."""
    radius = {o.name: o.footprint_radius for o in scenes.source}
    others = [p for p in layout(scenes, Role.SOURCE, seed) if p.name != name]
    reach = TOWER_REACH if _carries_a_tower(scenes.steps, name) else MAX_REACH
    x_min, x_max, y_min, y_max = REGION
    best, clearance = (0.0, 0.0), -np.inf
    for x in np.arange(x_min, x_max, GRID):
        for y in np.arange(y_min, y_max, GRID):
            if np.hypot(x, y) > reach:
                continue
            gap = min(np.hypot(x - p.x, y - p.y) - radius[p.name] for p in others) - radius[name]
            if gap > clearance:
                best, clearance = (float(x), float(y)), gap
    if clearance < RESERVED_GAP:
        raise MbdError(f"{scenes.task}: there is no free place to put '{name}' aside; leave more room on the table")
    return best


def _carries_a_tower(steps: Sequence[DemonstratedStep], name: str) -> bool:
    """Whether something is placed onto what is placed onto an object."""
    onto = {s.picked: s.onto for s in steps if s.kind is StepKind.PLACE and s.onto}
    return any(onto.get(below) == name for below in onto.values())
