"""The families of teachers, and which of them may be used for a choice.

The split was written down before anything was fitted. CHOOSE: priors, errors, thresholds and defaults are chosen on
these. REPORT: used for no choice at all; what is claimed is claimed of these.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from mbd_mapping.strategy import Pair

from mbd_experiments.teacher_families import choosing, scenes
from mbd_experiments.teacher_families.choosing import Choice
from mbd_experiments.teacher_families.lesson import Lesson, Scenes, told_in_order

Rng = np.random.Generator
NOISE_OF_CHOICE = 0.03  # of the teacher who chooses by softmax [similarity]
LARGE = (13, 20, 30)
SPOILED = 0.4  # share of the sessions with an error


class Half(StrEnum):
    """What a family may be used for."""

    CHOOSE = "choose"
    REPORT = "report"


@dataclass(frozen=True)
class Family:
    """A kind of teacher in a kind of scenes.

    Attributes:
        name: of the family.
        half: what it may be used for.
        make: a random lesson.
        counts: after how many assists it is judged; None: after each.
    """

    name: str
    half: Half
    make: Callable[[Rng], Lesson]
    counts: tuple[int, ...] | None = None


def _lesson(make_scenes: Callable[[Rng], Scenes], choose: Callable[[Rng, Scenes], Choice]) -> Callable[[Rng], Lesson]:
    def make(rng: Rng) -> Lesson:
        made = make_scenes(rng)
        columns, score = choose(rng, made)
        return Lesson(made.seen_source, made.seen_target, columns, score, told_in_order(rng, columns))

    return make


def _one(rng: Rng, made: Scenes) -> Choice:
    return choosing.by_set(made, choosing.one_of(rng, (1,)))


def _two(rng: Rng, made: Scenes) -> Choice:
    return choosing.by_set(made, choosing.one_of(rng, (2,)))


def _one_or_two(rng: Rng, made: Scenes) -> Choice:
    return choosing.by_set(made, choosing.one_of(rng, (1, 2)))


def _more(rng: Rng, made: Scenes) -> Choice:
    return choosing.by_set(made, choosing.larger_set(rng))


def _left_to_right(_: Rng, made: Scenes) -> Choice:
    return choosing.by_rank(choosing.rightness(made.source.positions), choosing.rightness(made.target.positions))


def _near_to_far(_: Rng, made: Scenes) -> Choice:
    return choosing.by_rank(choosing.depth(made.source.positions), choosing.depth(made.target.positions))


def _rank_of_size(_: Rng, made: Scenes) -> Choice:
    return choosing.by_rank(made.source.volume, made.target.volume)


def _antagonist(rng: Rng, made: Scenes) -> Choice:
    if rng.random() < 0.5:
        return choosing.by_rank(made.source.volume, -made.target.volume)
    return choosing.by_rank(choosing.rightness(made.source.positions), -choosing.rightness(made.target.positions))


def _softly(rng: Rng, made: Scenes) -> Choice:
    return choosing.softly(rng, made, NOISE_OF_CHOICE)


def _changes_mind(rng: Rng) -> Lesson:
    """Half of the assists by one feature; from then on by another, what was told standing."""
    made = scenes.plain(rng)
    first, _ = _one(rng, made)
    _, score = _one(rng, made)
    order = [int(row) for row in rng.permutation(len(first))]
    kept = {row: first[row] for row in order[: len(order) // 2]}
    bound = np.array(score, dtype=float)
    for row, column in kept.items():
        bound[row, :], bound[:, column] = -1e3, -1e3
        bound[row, column] = 1e3
    columns = choosing.best_of(bound)
    return Lesson(made.seen_source, made.seen_target, columns, bound, tuple((r, columns[r]) for r in order))


def _two_exchanged(rng: Rng) -> Lesson:
    """Six objects; in some sessions two of the first five assists are given for each other."""
    lesson = _lesson(lambda r: scenes.plain(r, (6,)), _one_or_two)(rng)
    assists = list(lesson.assists[:-1])
    if rng.random() < SPOILED:
        a, b = (int(k) for k in rng.choice(len(assists), 2, replace=False))
        (row_a, column_a), (row_b, column_b) = assists[a], assists[b]
        assists[a], assists[b] = (row_a, column_b), (row_b, column_a)
    return replace(lesson, assists=tuple(assists))


def _one_wrong(rng: Rng) -> Lesson:
    """Six objects; in some sessions one of the first five assists names another target."""
    lesson = _lesson(lambda r: scenes.plain(r, (6,)), _one_or_two)(rng)
    assists: list[Pair] = list(lesson.assists[:-1])
    if rng.random() < SPOILED:
        place = int(rng.integers(len(assists)))
        row, column = assists[place]
        assists[place] = row, int(rng.choice([c for c in range(len(lesson.target)) if c != column]))
    return replace(lesson, assists=tuple(assists))


def _unequal(rng: Rng) -> Scenes:
    return scenes.unequal(rng) if rng.random() < 0.5 else scenes.unequal_unlike(rng)


def _many(rng: Rng) -> Scenes:
    return scenes.plain(rng, LARGE)


SOME = (0, 1, 2, 3, 5, 8, 11)

FAMILIES = (
    Family("one feature", Half.CHOOSE, _lesson(scenes.plain, _one)),
    Family("two features", Half.CHOOSE, _lesson(scenes.plain, _two)),
    Family("weights", Half.CHOOSE, _lesson(scenes.plain, choosing.by_weights)),
    Family("left to right", Half.CHOOSE, _lesson(scenes.plain, _left_to_right)),
    Family("unmeasured", Half.CHOOSE, _lesson(scenes.plain, choosing.anyhow)),
    Family("camera noise", Half.CHOOSE, _lesson(scenes.through_a_camera, _one)),
    Family("noisy teacher", Half.CHOOSE, _lesson(scenes.plain, _softly)),
    Family("two exchanged", Half.CHOOSE, _two_exchanged),
    Family("three or four features", Half.REPORT, _lesson(scenes.plain, _more)),
    Family("near to far", Half.REPORT, _lesson(scenes.plain, _near_to_far)),
    Family("rank of size", Half.REPORT, _lesson(scenes.plain, _rank_of_size)),
    Family("largest to smallest, mirrored", Half.REPORT, _lesson(scenes.plain, _antagonist)),
    Family("changes mind", Half.REPORT, _changes_mind),
    Family("heavy-tailed sizes", Half.REPORT, _lesson(scenes.heavy_tailed, _one_or_two)),
    Family("few values", Half.REPORT, _lesson(scenes.few_values, _one_or_two)),
    Family("one feature, ties by another", Half.REPORT, _lesson(scenes.plain, choosing.lexicographic)),
    Family("13 to 30 objects", Half.REPORT, _lesson(_many, _one_or_two), SOME),
    Family("distractors or missing", Half.REPORT, _lesson(_unequal, _one_or_two)),
    Family("one wrong", Half.REPORT, _one_wrong),
)
