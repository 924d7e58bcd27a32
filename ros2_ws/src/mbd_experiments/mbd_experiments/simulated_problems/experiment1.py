"""Experiment 1 (paper sec. 5): random problems, 26 ground truths each, every order of assists.

What a strategy states depends on the set of assists, not on their order, so the n! orders pass through 2^n states: each
is inferred once, and the share of orders that are solved within k assists is counted by going up the sets.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from mbd_mapping.assignment.assignment import Columns
from mbd_mapping.config import FeatureSpace, MappingConfig
from mbd_mapping.inference import STRATEGIES
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import Pair, Prediction
from mbd_mapping.synthetic import random_problem
from mbd_mapping.tables import Floats, ObjectTable

from mbd_experiments.simulated_problems.ground_truth import TRUTHS, best_mapping

EQUAL = 1e-9
CONFIG = MappingConfig(feature_space=FeatureSpace.ALL)


@dataclass(frozen=True)
class TeacherTruth:
    """What the teacher of one run goes by.

    Attributes:
        features: the feature set.
        columns: (n,) the mapping the teacher has in mind, one of the best for the set.
        score: (n, n) what it is best for.
    """

    features: tuple[int, ...]
    columns: tuple[int, ...]
    score: Floats

    def allows(self, columns: Sequence[int]) -> bool:
        """True when the mapping is as good for the set as the teacher's: it is right."""
        rows = np.arange(len(self.columns))
        return float(self.score[rows, list(columns)].sum()) >= float(self.score[rows, list(self.columns)].sum()) - EQUAL


@dataclass(frozen=True)
class SolvedShare:
    """One problem, truth and strategy after k assists, over all sets and orders of k assists.

    Attributes:
        size, problem, features, strategy, assists: which.
        solved_at: share of the sets of k assists after which the one predicted mapping is the teacher's.
        solved_within: share of the orders in which that was so after k assists or earlier.
    """

    size: int
    problem: int
    features: tuple[int, ...]
    strategy: str
    assists: int
    solved_at: float
    solved_within: float


@dataclass(frozen=True)
class Judged:
    """One inference whose confidence can be held against the truth.

    Attributes:
        strategy: which.
        scenario: "clean", or what was done to the assists.
        size, assists: n and k.
        confidence: what the strategy computed.
        right: whether its mapping was as good as the teacher's.
        solved: whether it was the only one predicted, and the teacher's.
        weight: how many orders of assists pass through it, as a share.
    """

    strategy: str
    scenario: str
    size: int
    assists: int
    confidence: float
    right: bool
    solved: bool
    weight: float = 1.0


class Problem:
    """One random problem with its truths; every inference on it is made once.

    Args:
        seed: of the complete experiment; the same seed gives the same problem.
        size: n.
        number: which of the problems of that size.
    """

    def __init__(self, seed: int, size: int, number: int) -> None:
        self.size, self.number = size, number
        source, target = random_problem(np.random.default_rng([seed, size, number]), size)
        tables = ObjectTable.of(source.objects), ObjectTable.of(target.objects)
        self._comparisons = {name: Comparison.of(*tables, replace(CONFIG, strategy=name)) for name in STRATEGIES}
        first = next(iter(self._comparisons.values()))
        self.truths = []
        for features in TRUTHS:
            score, columns = best_mapping(first, features)
            self.truths.append(TeacherTruth(features, columns, score))
        self._known: dict[tuple[str, tuple[Pair, ...]], Prediction] = {}

    def comparison(self, strategy: str) -> Comparison:
        """The scenes, compared as the strategy wants them."""
        return self._comparisons[strategy]

    def infer(self, strategy: str, pairs: Sequence[Pair]) -> Prediction:
        """The prediction from these assists, in any order."""
        key = strategy, tuple(sorted(pairs))
        if key not in self._known:
            self._known[key] = STRATEGIES[strategy](self._comparisons[strategy], key[1], ())
        return self._known[key]

    def run(self, strategy: str, truth: TeacherTruth) -> tuple[list[SolvedShare], list[Judged]]:
        """All 2^n states of one truth."""
        n = self.size
        at, within, judged = np.zeros(n + 1), np.zeros(n + 1), []
        unsolved: dict[tuple[int, ...], int] = {}
        for k in range(n + 1):
            for rows in itertools.combinations(range(n), k):
                found = self.infer(strategy, [(row, truth.columns[row]) for row in rows])
                solved = found.ties == 1 and found.columns == truth.columns
                right = truth.allows(found.columns)
                weight = 1.0 / math.comb(n, k)
                judged.append(Judged(strategy, "clean", n, k, found.confidence, right, solved, weight))
                # Orders of these assists in which no earlier state was solved either.
                orders = 1 if not rows else sum(unsolved[rows[:i] + rows[i + 1 :]] for i in range(k))
                unsolved[rows] = 0 if solved else orders
                at[k] += solved * weight
                within[k] += (math.factorial(k) - unsolved[rows]) / math.perm(n, k)
        outcomes = [
            SolvedShare(n, self.number, truth.features, strategy, k, float(at[k]), float(within[k]))
            for k in range(n + 1)
        ]
        return outcomes, judged


def run_problem(seed: int, runs: int, which: tuple[int, int]) -> tuple[list[SolvedShare], list[Judged]]:
    """Every strategy and truth of one problem, without errors and, ``runs`` times each, with them.

    Args:
        seed: of the complete experiment.
        runs: with wrong assists of each truth.
        which: the problem's number of objects, and its number among those of that size.
    """
    size, number = which
    problem = Problem(seed, size, number)
    outcomes: list[SolvedShare] = []
    judged: list[Judged] = []
    rng = np.random.default_rng([seed, size, number, 1])
    for truth in problem.truths:
        orders = [rng.permutation(size)[: size - 1] for _ in range(runs)]
        erroneous = [list(spoiled_assists(rng, truth, order)) for order in orders]
        for strategy in STRATEGIES:
            found = problem.run(strategy, truth)
            outcomes += found[0]
            judged += found[1]
            for scenarios in erroneous:
                for scenario, assists in scenarios:
                    judged += list(_judge(problem, strategy, truth, scenario, assists))
    return outcomes, judged


def spoiled_assists(
    rng: np.random.Generator, truth: TeacherTruth, order: Columns, share: float = 0.4
) -> Iterator[tuple[str, list[Pair]]]:
    """N - 1 assists in this order; in a share of the runs one is wrong, or (another scenario) two are exchanged."""
    right = [(int(row), truth.columns[row]) for row in order]
    wrong = list(right)
    if rng.random() < share:
        place = int(rng.integers(len(wrong)))
        row, column = wrong[place]
        others = [c for c in range(len(truth.columns)) if c != column]
        wrong[place] = row, int(rng.choice(others))
    yield "one wrong in 40%", wrong
    exchanged = list(right)
    if rng.random() < share:
        a, b = (int(k) for k in rng.choice(len(exchanged), 2, replace=False))
        (row_a, column_a), (row_b, column_b) = exchanged[a], exchanged[b]
        exchanged[a], exchanged[b] = (row_a, column_b), (row_b, column_a)
    yield "two exchanged in 40%", exchanged


def _judge(
    problem: Problem, strategy: str, truth: TeacherTruth, scenario: str, assists: Sequence[Pair]
) -> Iterator[Judged]:
    for k in range(len(assists) + 1):
        # The first of contradicting assists stands for "mbd", so their order matters there.
        found = STRATEGIES[strategy](problem.comparison(strategy), assists[:k], ())
        solved = found.ties == 1 and found.columns == truth.columns
        yield Judged(strategy, scenario, problem.size, k, found.confidence, truth.allows(found.columns), solved)


def random_baseline(size: int, assists: int) -> float:
    """Share of orders solved within k assists by guessing any mapping each time."""
    return 1.0 - (1.0 - 1.0 / math.factorial(size)) ** (assists + 1)


def pruning_baseline(size: int, assists: int) -> float:
    """The same by guessing a mapping that holds the assists (paper sec. 5)."""
    return 1.0 - math.prod(1.0 - 1.0 / math.factorial(size - k) for k in range(assists + 1))


def calibration_error(judged: Sequence[Judged], bins: int = 10) -> float:
    """Expected calibration error: mean distance of confidence and share right over equal bins of confidence."""
    if not judged:
        return 0.0
    confidence = np.array([j.confidence for j in judged])
    right = np.array([j.right for j in judged], dtype=float)
    weight = np.array([j.weight for j in judged])
    place = np.minimum((confidence * bins).astype(int), bins - 1)
    gaps = np.bincount(place, weights=weight * (confidence - right), minlength=bins)
    return float(np.abs(gaps).sum() / weight.sum())
