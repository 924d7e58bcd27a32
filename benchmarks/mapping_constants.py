"""Where the constants of strategy "evidence" come from: four tables, all of simulated problems.

    python benchmarks/mapping_constants.py            (a few minutes)

1. assist_error, swap_error, no_feature: calibration and mean log score of the confidence on experiment 1's problems.
2. similarity_noise: calibration where features are measured with errors.
3. threshold: right answers and assists by stopping threshold, single features.
4. generators: what is solved within two assists on other random objects, beside a strategy given more than it can know.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from mbd_experiments.simulated_problems.experiment1 import Judged, TeacherTruth, calibration_error, spoiled_assists
from mbd_experiments.simulated_problems.ground_truth import TRUTHS, best_mapping
from mbd_mapping.config import FeatureSpace, MappingConfig
from mbd_mapping.evidence import infer_evidence
from mbd_mapping.inference import STRATEGIES
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import Pair
from mbd_mapping.synthetic import random_problem
from mbd_mapping.tables import ObjectTable
from mbd_model.objects import Scene
from mbd_model.spatial import spatial_relations

SEED = 77
CONFIG = MappingConfig(strategy="evidence")
HUE_ERROR, EDGE_ERROR, PLACE_ERROR = 5.0, 0.04, 0.01  # [deg], share, [m]: standard deviations of measuring


def problems(seed: int, size: int, count: int) -> Iterator[tuple[Scene, Scene]]:
    """Random problems of experiment 1."""
    rng = np.random.default_rng([seed, size])
    return (random_problem(rng, size) for _ in range(count))


def compare(scenes: Sequence[Scene], config: MappingConfig) -> Comparison:
    """Two scenes, compared."""
    return Comparison.of(ObjectTable.of(scenes[0].objects), ObjectTable.of(scenes[1].objects), config)


def truths(comparison: Comparison, sets: Sequence[tuple[int, ...]]) -> list[TeacherTruth]:
    """What teachers who go by these sets have in mind."""
    found = ((features, *best_mapping(comparison, features)) for features in sets)
    return [TeacherTruth(features, columns, score) for features, score, columns in found]


def judge(comparison: Comparison, truth: TeacherTruth, name: str, assists: Sequence[Pair], gap: float = 0.0) -> Judged:
    """One inference against the truth; ``gap`` is how much worse still counts as right."""
    found = infer_evidence(comparison, assists, ())
    rows = np.arange(len(truth.columns))
    lost = truth.score[rows, list(truth.columns)].sum() - truth.score[rows, list(found.columns)].sum()
    solved = found.columns == truth.columns
    return Judged("evidence", name, len(rows), len(assists), found.confidence, bool(lost <= gap + 1e-9), solved)


def log_score(judged: Sequence[Judged]) -> float:
    """Mean logarithm of the probability given to what turned out."""
    return float(np.mean([math.log(max(1e-9, j.confidence if j.right else 1.0 - j.confidence)) for j in judged]))


def errors_table(count: int = 8, size: int = 6) -> Iterator[str]:
    """Table 1."""
    rng = np.random.default_rng(SEED)
    cases = []
    for scenes in problems(SEED, size, count):
        for truth in truths(compare(scenes, CONFIG), TRUTHS):
            order = rng.permutation(size)[: size - 1]
            clean = [(int(row), truth.columns[row]) for row in order]
            cases += [
                (scenes, truth, "clean", clean),
                *((scenes, truth, *s) for s in spoiled_assists(rng, truth, order)),
            ]
    yield "1. no_feature assist_error swap_error: log score (calibration error) clean, one wrong, two exchanged; sum"
    for no_feature, assist_error, swap_error in itertools.product((1e-6, 1e-3), (0.03, 0.06, 0.1), (0.05, 0.1, 0.2)):
        config = replace(
            CONFIG,
            feature_space=FeatureSpace.ALL,
            no_feature=no_feature,
            assist_error=assist_error,
            swap_error=swap_error,
        )
        known: dict[int, Comparison] = {}
        judged: dict[str, list[Judged]] = {}
        for scenes, truth, name, assists in cases:
            comparison = known.setdefault(id(scenes), compare(scenes, config))
            judged.setdefault(name, []).extend(judge(comparison, truth, name, assists[:k]) for k in (1, 2, 3, size - 1))
        scores = [log_score(group) for group in judged.values()]
        cells = [f"{s:.3f} ({calibration_error(g):.3f})" for s, g in zip(scores, judged.values(), strict=True)]
        yield f"   {no_feature:g} {assist_error:g} {swap_error:g}: {'  '.join(cells)}; {sum(scores):.3f}"


def measured(rng: np.random.Generator, scene: Scene) -> Scene:
    """The scene as a camera with errors sees it."""
    objects = [
        replace(
            o,
            centroid=tuple(float(v) for v in np.array(o.centroid) + rng.normal(0.0, PLACE_ERROR, 3)),
            size=tuple(float(v) for v in np.array(o.size) * np.exp(rng.normal(0.0, EDGE_ERROR, 3))),
            hue=float(((o.hue or 0.0) + rng.normal(0.0, HUE_ERROR)) % 360.0),
            volume=math.nan,
        )
        for o in scene.objects
    ]
    relations = spatial_relations(objects)
    return replace(scene, objects=tuple(replace(o, relations=r) for o, r in zip(objects, relations, strict=True)))


def noise_table(count: int = 30, size: int = 6) -> Iterator[str]:
    """Table 2."""
    yield (
        "2. similarity_noise, features measured with errors: calibration error, confidence and share right; "
        "share solved with all assists but one given"
    )
    for noise in (0.0, 0.005, 0.01, 0.02, 0.04):
        rng = np.random.default_rng(SEED)
        config = replace(CONFIG, similarity_noise=noise)
        judged = []
        for scenes in problems(SEED, size, count):
            seen = compare([measured(rng, scene) for scene in scenes], config)
            for truth in truths(compare(scenes, config), [s for s in TRUTHS if len(s) == 1]):
                order = [(int(row), truth.columns[row]) for row in rng.permutation(size)]
                judged += [judge(seen, truth, "measured", order[:k], 2 * noise) for k in range(size)]
        sure, right = np.mean([j.confidence for j in judged]), np.mean([j.right for j in judged])
        solved = np.mean([j.solved for j in judged if j.assists == size - 1])
        yield f"   {noise:g}: {calibration_error(judged):.3f}, {sure:.2f} {right:.2f}; {solved:.2f}"


def threshold_table(count: int = 30) -> Iterator[str]:
    """Table 3."""
    rng = np.random.default_rng(SEED)
    runs = []
    for size in (4, 5, 6):
        for scenes in problems(SEED, size, count):
            comparison = compare(scenes, CONFIG)
            for truth in truths(comparison, [s for s in TRUTHS if len(s) == 1]):
                order = [(int(row), truth.columns[row]) for row in rng.permutation(size)]
                runs.append([judge(comparison, truth, "clean", order[:k]) for k in range(size + 1)])
    yield "3. threshold: assists on average, share right, right answers bought an assist"
    none = float(np.mean([run[0].right for run in runs]))
    for threshold in (0.2, 0.25, 0.3, 1 / 3, 0.36, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9):
        stops = [next((j for j in run if j.confidence >= threshold), run[-1]) for run in runs]
        assists, right = np.mean([j.assists for j in stops]), np.mean([j.right for j in stops])
        bought = (right - none) / assists if assists else 0.0
        yield f"   {threshold:.2f}: {assists:.2f} {right:.2f} {bought:.3f}"


def within_two(comparison: Comparison, columns: Sequence[int]) -> float:
    """Share of the orders of two assists within which the mapping is found."""
    strategy, size = STRATEGIES[comparison.config.strategy], len(columns)

    @cache
    def solved(rows: tuple[int, ...]) -> bool:
        found = strategy(comparison, [(row, columns[row]) for row in rows], ())
        return found.ties == 1 and found.columns == tuple(columns)

    orders = list(itertools.permutations(range(size), 2))
    return sum(solved(()) or solved((a,)) or solved((min(a, b), max(a, b))) for a, b in orders) / len(orders)


def with_volumes(rng: np.random.Generator, scenes: Sequence[Scene], factor: float) -> list[Scene]:
    """The same objects, reused ones the same again, with volumes log-uniform over a factor."""
    volumes = {o.hue: 1e-4 * factor ** rng.random() for scene in scenes for o in scene.objects}
    return [replace(s, objects=tuple(replace(o, volume=float(volumes[o.hue])) for o in s.objects)) for s in scenes]


def generators_table(count: int = 10) -> Iterator[str]:
    """Table 4."""
    both = FeatureSpace.ALL
    configs = {
        "mbd": MappingConfig(feature_space=both),
        "evidence": replace(CONFIG, feature_space=both),
        "given that the truths are small and the assists right": replace(
            CONFIG, feature_space=both, assist_error=1e-4, swap_error=0.0, large_set_odds=1e-9
        ),
    }
    yield "4. share solved within two assists: edges [m], volumes, n, seed"
    rows = [((0.06, 0.10), 0.0, 6, seed) for seed in (1, 2, 3, 4)]
    rows += [((0.03, 0.15), 0.0, 6, 1), ((0.03, 0.15), 0.0, 6, 2), ((0.02, 0.10), 0.0, 6, 1)]
    rows += [((0.06, 0.10), 60.0, 6, 1), ((0.06, 0.10), 60.0, 6, 2)]
    rows += [((0.06, 0.10), 0.0, 7, seed) for seed in (1, 2, 3)]
    for edge, factor, size, seed in rows:
        shares: dict[str, list[float]] = {name: [] for name in configs}
        for number in range(count):
            rng = np.random.default_rng([seed, size, number])
            scenes: Sequence[Scene] = random_problem(rng, size, edge)
            if factor:
                scenes = with_volumes(rng, scenes, factor)
            for name, config in configs.items():
                comparison = compare(scenes, config)
                shares[name] += [within_two(comparison, t.columns) for t in truths(comparison, TRUTHS)]
        mean = {name: float(np.mean(share)) for name, share in shares.items()}
        cells = ", ".join(f"{name} {share:.3f}" for name, share in mean.items())
        volumes = f"over a factor of {factor:g}" if factor else "of the edges"
        yield f"   {edge} {volumes} {size} {seed}: {cells}; ratio {mean['evidence'] / mean['mbd']:.2f}"


if __name__ == "__main__":
    for line in itertools.chain(threshold_table(), noise_table(), errors_table(), generators_table()):
        sys.stdout.write(line + "\n")
        sys.stdout.flush()
