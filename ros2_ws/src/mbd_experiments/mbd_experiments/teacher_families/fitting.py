"""``fit_priors``: the priors of strategy "evidence", fitted to the CHOOSE half of the families.

A posterior is linear in the shares of the groups and levels, so each state of each lesson is inferred once and kept as
sums by group and level; every set of shares is then tried in milliseconds. Sought is the greatest likelihood: the least
mean of -log P(the teacher's mapping) over the families, of which the paper's own teachers, who go by one feature or by
two, have half the weight (WEIGHTS) and the others share the rest; plus by how much the share right falls short of 0.9
where two assists were exchanged and all but one are given. The noises and errors are gone through on a grid around
that. Calibration is no part of it: it is what the suite then reports.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from mbd_mapping.assignment.assignment import Columns
from mbd_mapping.config import MappingConfig
from mbd_mapping.evidence import Posterior
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import UNMAPPED
from mbd_mapping.tables import Floats
from mbd_mapping.teachers.assist_likelihood import AssistLikelihood
from mbd_mapping.teachers.hypotheses import GROUPS, LEVELS, hypotheses_of
from mbd_mapping.teachers.priors import Group, Level, Priors
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero, at_least_one, zero_to_one
from rich.console import Console

from mbd_experiments.teacher_families.families import FAMILIES, Half
from mbd_experiments.teacher_families.lesson import Lesson
from mbd_experiments.teacher_families.measures import BINS
from mbd_experiments.teacher_families.suite import lessons_of

CELLS = len(GROUPS) * len(LEVELS)
EVEN = Priors(groups=tuple((g, 1.0) for g in Group), levels=tuple((v, 1.0) for v in Level))
MAX_MAPPINGS = 24
Kind = TypeVar("Kind", Group, Level)
DERIVED = 1.0 / 3.0
EXCHANGED, GUESS_RIGHT = "two exchanged", 0.9
WEIGHTS = {"one feature": 0.3, "two features": 0.2}  # the rest is shared equally


@dataclass(frozen=True)
class States:
    """Every state of one family's lessons, S of them, before groups and levels are weighed.

    Attributes:
        evidence: (S, CELLS) probability of the claims with each group and level, but for a factor a state.
        joint, good: (S, CELLS, C) with each mapping, and with its being right; C padded with zeros.
        right: (S, C) whether each mapping is right.
        truth: (S, CELLS) with the teacher's own mapping.
        last: (S,) whether it is the last of its lesson.
    """

    evidence: Floats
    joint: Floats
    good: Floats
    right: Floats
    truth: Floats
    last: Floats

    def log_truth(self, shares: Floats) -> float:
        """Mean log probability of the teacher's own mapping under shares (CELLS,)."""
        return float(np.log(np.maximum(self.truth @ shares / (self.evidence @ shares), 1e-12)).mean())

    def judged(self, shares: Floats) -> tuple[Floats, Floats]:
        """((S,) confidence, (S,) right) of the most probable mapping under shares (CELLS,)."""
        total = self.evidence @ shares
        score = np.tensordot(shares, self.joint, axes=([0], [1])) / total[:, None]
        best = score.argmax(axis=1)
        every = np.arange(len(best))
        confidence = np.tensordot(shares, self.good, axes=([0], [1]))[every, best] / total
        return np.minimum(confidence, 1.0), self.right[every, best]


def states_of(lessons: Sequence[Lesson], config: MappingConfig) -> States:
    """Infer every state once, all groups and levels alike."""
    parts = [state for lesson in lessons for state in _lesson_states(lesson, config)]
    evidence, joint, good, right, truth, last = (np.array(side) for side in zip(*parts, strict=True))
    return States(evidence, joint, good, right, truth, last)


def _lesson_states(lesson: Lesson, config: MappingConfig) -> Iterator[tuple[Floats, ...]]:
    comparison = Comparison.of(lesson.source, lesson.target, config)
    hypotheses = hypotheses_of(comparison)
    n, m = len(lesson.source), len(lesson.target)
    cell = hypotheses.group * len(LEVELS) + hypotheses.level
    mapped = sum(c != UNMAPPED for c in lesson.columns)
    counts = range(min(mapped, len(lesson.assists) + 1))
    for k in counts:
        likelihoods = AssistLikelihood.of(lesson.assists[:k], max(n, m), m, config)
        posterior = Posterior.of(hypotheses, likelihoods)
        evidence = _by_cell(cell, posterior.probability)
        joint, good, right = np.zeros((CELLS, MAX_MAPPINGS)), np.zeros((CELLS, MAX_MAPPINGS)), np.zeros(MAX_MAPPINGS)
        for place, c in enumerate(posterior.ranked()[:MAX_MAPPINGS]):
            joint[:, place] = _by_cell(cell, posterior.joint[:, c])
            good[:, place] = _by_cell(cell, posterior.good(posterior.squares[c]))
            right[place] = lesson.is_right([int(v) if v < m else UNMAPPED for v in posterior.squares[c][:n]])
        square = _square_of(lesson, m)
        own = np.exp(likelihoods.log_prior_of(hypotheses, square[None])[:, 0] - posterior.log_evidence)
        own *= likelihoods.of_mappings(square[None])[0] * hypotheses.copies
        yield evidence, joint, good, right, _by_cell(cell, own), np.array(float(k == counts[-1]))


def _by_cell(cell: Columns, values: Floats) -> Floats:
    """(CELLS,) sums of values (H,) by group and level (H,)."""
    sums: Floats = np.bincount(cell, weights=values, minlength=CELLS).astype(float)
    return sums


def _square_of(lesson: Lesson, targets: int) -> Columns:
    """The teacher's mapping over N rows and columns: what is left goes to nothing in order."""
    n, size = len(lesson.columns), max(len(lesson.columns), targets)
    square = np.full(size, UNMAPPED)
    square[:n] = lesson.columns
    left = np.setdiff1d(np.arange(size), square)
    square[square == UNMAPPED] = left
    return square


def shares_of(priors: Priors) -> Floats:
    """(CELLS,) what each group and level counts, relative to EVEN; the teacher of nothing has one level."""
    groups = np.array([priors.group(g) for g in GROUPS])
    levels = np.array([priors.level(v) for v in LEVELS])
    table = groups[:, None] * (levels / levels.sum())[None, :] * len(LEVELS)
    table[GROUPS.index(Group.OTHER)] = groups[GROUPS.index(Group.OTHER)]
    flat: Floats = table.ravel()
    return flat


def family_error(confidence: Floats, right: Floats) -> float:
    """Expected calibration error."""
    place = np.minimum((confidence * BINS).astype(int), BINS - 1)
    return float(np.abs(np.bincount(place, weights=confidence - right, minlength=BINS)).sum() / len(right))


def weights_of(names: Collection[str]) -> dict[str, float]:
    """How much each family counts; they sum to 1 where those of WEIGHTS are among them."""
    others = [name for name in names if name not in WEIGHTS]
    return {name: WEIGHTS.get(name, (1.0 - sum(WEIGHTS.values())) / max(1, len(others))) for name in names}


def loss(families: Mapping[str, States], priors: Priors) -> float:
    """What is to be made small."""
    shares = shares_of(priors)
    weights = weights_of(families)
    missing = 0.0
    if EXCHANGED in families:
        states = families[EXCHANGED]
        missing = max(0.0, GUESS_RIGHT - float(states.judged(shares)[1][states.last.astype(bool)].mean()))
    return 2.0 * missing - sum(weights[name] * states.log_truth(shares) for name, states in families.items())


def fit_shares(families: Mapping[str, States], start: Priors, rng: np.random.Generator, rounds: int = 1200) -> Priors:
    """Shares of less and less loss, by random steps that are kept where they help."""
    best, least = start, loss(families, start)
    for number in range(rounds):
        width = 1.0 if number < rounds // 3 else 0.4 if number < 2 * rounds // 3 else 0.15
        tried = _stepped(best, rng, width)
        found = loss(families, tried)
        if found < least:
            best, least = tried, found
    return best


def _stepped(priors: Priors, rng: np.random.Generator, width: float) -> Priors:
    groups = {g: v * float(np.exp(rng.normal(0.0, width))) for g, v in priors.groups}
    levels = {v: s * float(np.exp(rng.normal(0.0, width))) for v, s in priors.levels}
    return replace(priors, groups=_normal(_derived(groups)), levels=_normal(levels))


def _derived(groups: dict[Group, float]) -> dict[Group, float]:
    """No family of the CHOOSE half tells these apart from their kin, so they take a fixed part of its share."""
    return groups | {Group.LARGER: DERIVED * groups[Group.PAIR], Group.REVERSED: DERIVED * groups[Group.ORDER]}


def _normal(table: Mapping[Kind, float]) -> tuple[tuple[Kind, float], ...]:
    whole = sum(table.values())
    return tuple((name, share / whole) for name, share in table.items())


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; prints what belongs into mbd_mapping/teachers/priors.py and config.py."""
    parser = CommandParser(prog="fit_priors", description=__doc__)
    parser.add_argument("--lessons", type=at_least_one, default=120, help="of each family")
    parser.add_argument("--seed", type=int, default=101, help="of the lessons; another than the suite's")
    parser.add_argument("--noise", type=above_zero, nargs="+", default=[0.02], help="similarity_noise tried")
    parser.add_argument("--loose", type=above_zero, nargs="+", default=[0.1], help="loose_noise tried")
    parser.add_argument("--error", type=zero_to_one, nargs="+", default=[0.04], help="assist_error tried")
    parser.add_argument("--swap", type=zero_to_one, nargs="+", default=[0.25], help="swap_error tried")
    options = parser.parse_args(arguments)
    console = Console(width=140)
    chosen = [f for f in FAMILIES if f.half == Half.CHOOSE]
    lessons = {f.name: lessons_of(f, options.seed, options.lessons) for f in chosen}
    start = replace(EVEN, groups=_normal(_derived(dict(EVEN.groups))), levels=_normal(dict(EVEN.levels)))
    for noise, loose, error, swap in itertools.product(options.noise, options.loose, options.error, options.swap):
        priors = replace(EVEN, loose_noise=loose)
        config = MappingConfig(
            strategy="evidence", similarity_noise=noise, assist_error=error, swap_error=swap, priors=priors
        )
        families = {name: states_of(own, config) for name, own in lessons.items()}
        best = fit_shares(families, replace(start, loose_noise=loose), np.random.default_rng(options.seed))
        found = loss(families, best)
        tried = f"similarity_noise {noise} loose_noise {loose} assist_error {error} swap_error {swap}"
        console.print(f"{tried}: {found:.4f}", highlight=False)
        console.print("  " + ", ".join(f"{g} {v:.3f}" for g, v in (*best.groups, *best.levels)))
        shares = shares_of(best)
        errors = {name: family_error(*states.judged(shares)) for name, states in families.items()}
        console.print("  ECE " + ", ".join(f"{name} {error:.3f}" for name, error in errors.items()), highlight=False)
        last = families[EXCHANGED].last.astype(bool)
        console.print(f"  {EXCHANGED}, all told: {families[EXCHANGED].judged(shares)[1][last].mean():.3f}")
        rates = {name: float(states.judged(shares)[1].mean()) for name, states in families.items()}
        console.print("  right " + ", ".join(f"{name} {rate:.3f}" for name, rate in rates.items()), highlight=False)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
