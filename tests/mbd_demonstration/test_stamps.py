"""Stamps that cannot be are named with the number; only what is certain is mended."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.clocks.stamps import checked, held

DATE = 1.7e9


def even(n: int, rate: float, begin: float = DATE) -> np.ndarray:
    return begin + np.arange(n) / rate


@given(seed=st.integers(0, 2**32), rate=st.floats(1, 1000), late=st.floats(0, 3))
def test_small_disorder_is_normal_and_is_left_as_it_came(seed, rate, late):
    """Up to a few sampling intervals: that is what networks do."""
    rng = np.random.default_rng(seed)
    stamps = even(200, rate)
    came = stamps[np.argsort(stamps + rng.uniform(0.0, late / rate, stamps.size))]
    found = checked(came, "x")
    assert found.notes == ()
    np.testing.assert_array_equal(found.stamps, came)


@given(rate=st.floats(1, 1000), before=st.integers(10, 300), back=st.floats(10, 2e9), pause=st.floats(0.0, 60.0))
def test_a_clock_that_went_back_is_named_and_the_order_of_arrival_kept(rate, before, back, pause):
    stamps = even(2 * before, rate, begin=0.0)
    arrivals = stamps + np.where(np.arange(stamps.size) >= before, pause, 0.0)
    stamps = stamps + DATE
    stamps[before:] -= back + before / rate
    found = checked(stamps, "the tool poses", arrivals)
    assert len(found.notes) == 1 and "the tool poses went back by" in found.notes[0]
    assert (np.diff(found.stamps) > 0.0).all()
    gap = found.stamps[before] - found.stamps[before - 1]
    assert gap == pytest.approx(pause + 1.0 / rate, rel=0.02, abs=1e-3)


def test_without_arrivals_the_pause_is_said_to_be_unknown():
    stamps = np.concatenate([even(50, 20.0), even(50, 20.0, begin=9.0)])
    found = checked(stamps, "the rows")
    assert "went back by 1.7e+09 s at sample 51 of 100" in found.notes[0] and "not known" in found.notes[0]
    assert found.stamps[50] - found.stamps[49] == pytest.approx(0.05, abs=1e-3)


def test_a_clock_that_was_set_forward_to_the_date_is_named():
    found = checked(np.concatenate([even(50, 20.0, begin=9.0), even(50, 20.0)]), "x")
    assert "went forward by 1.7e+09 s" in found.notes[0]
    assert (np.diff(found.stamps) > 0.0).all() and np.ptp(found.stamps) < 10.0


@given(rate=st.floats(1, 200), zeros=st.sets(st.integers(0, 99), min_size=1, max_size=30))
def test_samples_stamped_zero_among_dates_are_left_out_and_counted(rate, zeros):
    stamps = even(100, rate)
    stamps[list(zeros)] = 0.0
    found = checked(stamps, "x")
    assert len(found.notes) == 1 and f"{len(zeros)} of 100 stamps of x are zero" in found.notes[0]
    assert np.isnan(found.stamps).sum() == len(zeros)


@given(seed=st.integers(0, 2**32))
def test_rows_that_somebody_mixed_are_sorted_and_that_is_said(seed):
    stamps = np.random.default_rng(seed).permutation(even(400, 20.0, begin=0.0))
    found = checked(stamps, "the rows")
    assert len(found.notes) == 1 and "not in order of time" in found.notes[0]
    np.testing.assert_array_equal(found.stamps, stamps)


def test_a_tool_pose_that_its_driver_held_is_named_and_a_tool_that_rests_is_not():
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 20.0, 0.05)
    x = np.interp(t, [0, 5, 8, 15], [0.0, 0.5, 0.5, 1.2])
    path = np.stack([x, 0 * x, 0 * x], axis=1)
    assert held(t, path, "the tool pose") == ()
    path += rng.normal(0.0, 0.0005, path.shape)
    assert held(t, path, "the tool pose") == ()
    frozen = path.copy()
    frozen[(t >= 9) & (t < 12)] = frozen[np.searchsorted(t, 9)]
    [note] = held(t, frozen, "the tool pose")
    assert "repeated one value for 2.9 s from 9.0 s on" in note or "for 3.0 s from 9.0 s" in note
