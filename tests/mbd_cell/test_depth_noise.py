"""The depth camera errs as a structured-light one does."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from mbd_cell.physics.depth_noise import add_noise, noise_std

FOCAL = 580.0


def flat(depth: float) -> np.ndarray:
    return np.full((120, 160), depth, dtype=np.float32)


@given(st.floats(0.5, 2.0), st.integers(0, 100))
def test_a_facing_wall_is_measured_without_bias_and_with_the_stated_spread(depth: float, seed: int) -> None:
    noisy = add_noise(flat(depth), FOCAL, np.random.default_rng(seed))
    seen = noisy[noisy > 0]
    step = depth**2 / (FOCAL * 0.075) * 0.125
    spread = np.hypot(noise_std(np.float32(depth)), step / np.sqrt(12))
    assert abs(seen.mean() - depth) < 0.2 * spread + 0.5 * step
    assert 0.6 * spread < seen.std() < 1.5 * spread + 0.5 * step


def test_noise_grows_with_distance() -> None:
    std = []
    for depth in (0.6, 1.2, 1.8):
        noisy = add_noise(flat(depth), FOCAL, np.random.default_rng(1))
        std.append(noisy[noisy > 0].std())
    assert std[0] < std[1] < std[2]


def test_a_facing_wall_loses_almost_nothing_and_a_grazed_one_everything() -> None:
    # Twenty times farther away a pixel's width: an angle whose tangent is 20, all along.
    grazed = np.broadcast_to(0.8 * np.exp(20.0 / FOCAL * np.arange(40)), (120, 40)).astype(np.float32)
    assert (add_noise(flat(1.0), FOCAL, np.random.default_rng(1)) == 0).mean() < 0.01
    assert (add_noise(grazed, FOCAL, np.random.default_rng(1)) == 0).mean() > 0.95


def test_where_nothing_returns_nothing_is_made_up() -> None:
    depth = flat(1.0)
    depth[:, :50] = 0.0
    assert (add_noise(depth, FOCAL, np.random.default_rng(1))[:, :50] == 0).all()


def test_the_same_chance_gives_the_same_image() -> None:
    once, again = (add_noise(flat(1.0), FOCAL, np.random.default_rng(7)) for _ in range(2))
    assert np.array_equal(once, again)
