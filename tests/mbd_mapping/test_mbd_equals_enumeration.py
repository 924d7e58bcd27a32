"""The polynomial rule equals enumeration of every mapping."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mapping_oracle import TOLERANCE, enumerate_all
from mbd_mapping.config import FeatureSpace, MappingConfig, MissingHue
from mbd_mapping.feature_sets import feature_sets
from mbd_mapping.mbd import Competition, competing_sets, infer_mbd
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import Pair, first_assists
from mbd_mapping.synthetic import random_table


def random_case(seed: int, config: MappingConfig, largest: int) -> tuple[Comparison, list[Pair]]:
    """Two random scenes and any assists, contradictions included."""
    rng = np.random.default_rng(seed)
    n, m = (int(k) for k in rng.integers(1, largest + 1, 2))
    if rng.random() < 0.7:
        m = n
    variety = int(rng.integers(0, 4))
    source = random_table(rng, n, "s", variety)
    target = source if rng.random() < 0.2 else random_table(rng, m, "t", variety)
    assists = [(int(rng.integers(n)), int(rng.integers(len(target)))) for _ in range(int(rng.integers(0, n + 2)))]
    return Comparison.of(source, target, config), assists


def check(comparison: Comparison, assists: list[Pair]) -> None:
    """Prediction, ties, alpha, beta and confidence are those of enumeration."""
    pairs = first_assists(assists)
    layers, exists = comparison.at(pairs)
    members = competing_sets(comparison, pairs, exists)
    truth = enumerate_all(layers, members, pairs)
    found = infer_mbd(comparison, assists, ())
    assert found.score == pytest.approx(truth.value, abs=1e-9)
    assert found.columns in truth.tied
    assert found.ties == min(len(truth.tied), comparison.config.max_ties)
    # A count of ties that reaches the cap is a lower bound, and so is its share of the value an upper one.
    sure = truth.confidence if truth.beta is not None else truth.value / found.ties
    assert found.confidence == pytest.approx(max(0.0, min(1.0, sure)), abs=3e-9)
    assert found.winning == tuple(np.flatnonzero(members[truth.alpha]))
    assert bool(found.runner_up) == (truth.beta is not None)
    if truth.beta is not None:
        beta = feature_set_value(layers, found.runner_up, pairs)
        assert beta == pytest.approx(truth.beta_value, abs=TOLERANCE)
    if len(truth.tied) <= min(comparison.config.max_alternatives, comparison.config.max_ties):
        near = {c for c, v in found.alternatives if v >= found.score - TOLERANCE} | {found.columns}
        assert near == truth.tied


def feature_set_value(layers: np.ndarray, features: tuple[int, ...], pairs: tuple[Pair, ...]) -> float:
    """Best value of one feature set by enumeration."""
    member = np.zeros((1, 7), dtype=bool)
    member[0, list(features)] = True
    return enumerate_all(layers, member, pairs).value


@pytest.mark.parametrize("space", list(FeatureSpace))
@pytest.mark.parametrize("missing_hue", list(MissingHue))
@given(seed=st.integers(0, 2**32))
def test_equals_enumeration(space: FeatureSpace, missing_hue: MissingHue, seed: int) -> None:
    """Prediction, ties, alpha, beta and confidence are those of enumeration, whatever the scenes and assists."""
    config = MappingConfig(feature_space=space, missing_hue=missing_hue, max_ties=6000)
    check(*random_case(seed, config, largest=5))


@pytest.mark.parametrize("space", list(FeatureSpace))
def test_equals_enumeration_over_many_problems(space: FeatureSpace) -> None:
    """The same for three hundred problems of up to 7 objects, with the cap on ties in force."""
    config = MappingConfig(feature_space=space, max_ties=20, max_alternatives=20)
    for seed in range(300):
        check(*random_case(seed, config, largest=7 if seed % 20 == 0 else 5))


def test_pairs_that_almost_tie_end_too() -> None:
    """Pairs that each miss the best by less than the tolerance, but together by more, are not searched without end."""
    layers = np.ones((7, 20, 20))
    layers[0] -= 1e-8 * np.random.default_rng(0).random((20, 20))
    hue_alone = np.eye(1, 7, dtype=bool)
    race = Competition(layers, hue_alone, (), 1e-9)
    tied = race.tied(100)
    assert len(tied) >= 2
    assert all(value >= race.solve(0)[0] - 1e-9 for _, value in tied)


def test_every_set_is_there() -> None:
    """There are 7 single features and 127 non-empty sets, none twice."""
    assert len(feature_sets(FeatureSpace.SINGLE)) == 7
    assert len({tuple(row) for row in feature_sets(FeatureSpace.ALL)}) == 127
