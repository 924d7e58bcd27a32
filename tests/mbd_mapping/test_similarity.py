"""E states how alike two objects are, as sec. 4.3.1 defines it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.config import MappingConfig, MissingHue
from mbd_mapping.similarity import (
    AFFORDANCE,
    HUE,
    HUE_SHIFT,
    SIZE,
    SIZE_SHIFT,
    SPATIAL,
    Comparison,
    hue_difference,
    multiset_similarity,
    set_similarity,
)
from mbd_mapping.synthetic import random_table
from mbd_mapping.tables import ObjectTable

angle = st.floats(-720.0, 720.0)


def table(hue: list[float], volume: list[float]) -> ObjectTable:
    """Objects that have nothing but hue and volume."""
    n = len(hue)
    none = (frozenset[str](),) * n
    names = tuple(f"o{k}" for k in range(n))
    return ObjectTable(names, np.array(hue), np.array(volume), np.zeros((n, 4)), none, none)


@given(angle, angle)
def test_hue_difference_is_circular(a: float, b: float) -> None:
    """Full turns change nothing and no two hues are more than half a turn apart."""
    difference = float(hue_difference(np.array(a), np.array(b)))
    assert abs(difference) <= 180.0 + 1e-9
    assert math.isclose(math.cos(math.radians(difference)), math.cos(math.radians(a - b)), abs_tol=1e-9)


@given(st.integers(0, 2**32))
def test_every_similarity_is_in_the_unit_interval(seed: int) -> None:
    """No entry of E leaves [0, 1], with and without assists."""
    rng = np.random.default_rng(seed)
    comparison = Comparison.of(random_table(rng, 5, "s", 3), random_table(rng, 4, "t", 3), MappingConfig())
    for pairs in ((), ((0, 1),), ((0, 1), (3, 2))):
        layers, _ = comparison.at(pairs)
        assert np.isfinite(layers).all()
        assert (layers >= 0).all()
        assert (layers <= 1).all()


def test_an_object_is_most_like_itself() -> None:
    """Hue, size and sets of the same object have similarity 1."""
    source = random_table(np.random.default_rng(1), 6, "s")
    layers, _ = Comparison.of(source, source, MappingConfig()).at(())
    for feature in (HUE, SIZE, AFFORDANCE):
        assert np.diagonal(layers[feature]) == pytest.approx(1.0)


def test_equation_2_by_hand() -> None:
    """Opposite hues score exp(-180^2 / 2 (0.34 360)^2); twice the volume exp(-1 / 2 (0.34 dmax)^2)."""
    layers, _ = Comparison.of(table([0.0, 10.0], [1.0, 3.0]), table([180.0, 0.0], [2.0, 1.0]), MappingConfig()).at(())
    assert layers[HUE, 0, 0] == pytest.approx(math.exp(-(180.0**2) / (2 * (0.34 * 360) ** 2)))
    assert layers[SIZE, 0, 0] == pytest.approx(math.exp(-(1.0**2) / (2 * (0.34 * 3) ** 2)))


def test_shifts_do_not_exist_before_the_first_assist() -> None:
    """The shift layers appear with the first assist, and are then the mean over all of them."""
    comparison = Comparison.of(
        table([350.0, 20.0, 90.0], [1.0, 1.0, 1.0]), table([10.0, 60.0, 0.0], [2.0, 4.0, 1.0]), MappingConfig()
    )
    assert [comparison.at(())[1][k] for k in (HUE_SHIFT, SIZE_SHIFT)] == [False, False]
    assert comparison.shifts([(0, 0), (1, 1)]) == (pytest.approx(30.0), pytest.approx(3.0))
    layers, exists = comparison.at([(0, 0)])
    assert exists[HUE_SHIFT]
    assert layers[HUE_SHIFT, 0, 0] == pytest.approx(1.0)
    assert layers[SIZE_SHIFT, 1, 0] == pytest.approx(1.0)


def test_grey_favours_no_hue() -> None:
    """Grey is like grey, and as far from one hue as from any other."""
    layers, exists = Comparison.of(
        table([math.nan, 5.0], [1.0, 1.0]), table([math.nan, 100.0, 300.0], [1.0] * 3), MappingConfig()
    ).at([(0, 0)])
    assert layers[HUE, 0, 0] == 1.0
    assert layers[HUE, 0, 1] == layers[HUE, 0, 2] == layers[HUE, 1, 0] < 1.0
    assert not exists[HUE_SHIFT]


def test_as_recorded_takes_the_number() -> None:
    """As recorded, a missing hue is -1000 deg, which is 80 deg."""
    config = MappingConfig(missing_hue=MissingHue.AS_RECORDED)
    layers, _ = Comparison.of(table([math.nan], [1.0]), table([80.0], [1.0]), config).at(())
    assert layers[HUE, 0, 0] == pytest.approx(1.0)


def test_empty_sets() -> None:
    """An empty set is like an empty set and unlike any other."""
    empty, some = frozenset[str](), frozenset({"a"})
    assert set_similarity([empty, some], [empty, some], 0.34).tolist() == [
        [1.0, 0.0],
        [pytest.approx(math.exp(-1 / (2 * 0.34**2))), 1.0],
    ]


def test_relations_are_a_multiset() -> None:
    """Two objects on the left are not one: |x_i| = 2, overlap 1 gives D(2, 1, 2)."""
    found = multiset_similarity(np.array([[2.0, 0, 0, 0]]), np.array([[1.0, 0, 0, 3.0]]), 0.34)
    assert found[0, 0] == pytest.approx(math.exp(-1 / (2 * (0.34 * 2) ** 2)))
    assert SPATIAL == 4
