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


@given(rate=st.floats(10, 1000), before=st.integers(40, 300), back=st.floats(0.1, 0.9))
def test_a_clock_that_went_back_by_less_than_a_second_is_named_and_never_sorted(rate, before, back):
    """The times since then come twice; those of samples that overtook each other do not."""
    back = min(max(back, 5.0 / rate), 0.5 * before / rate)
    stamps = even(2 * before, rate, begin=0.0)
    stamps[before:] -= back
    found = checked(stamps, "the rows")
    assert len(found.notes) == 1 and f"went back by {back:.3g} s at sample {before + 1}" in found.notes[0]
    assert (np.diff(found.stamps) > 0.0).all()


def test_samples_that_come_late_in_one_go_are_sorted_as_ever():
    stamps = even(200, 30.0)
    came = np.concatenate([stamps[:50], stamps[65:80], stamps[50:65], stamps[80:]])
    found = checked(came, "x")
    assert found.notes == ()
    np.testing.assert_array_equal(found.stamps, came)


@given(rate=st.floats(5, 200), first=st.integers(5, 50), equal=st.integers(4, 60))
def test_a_stamp_that_stood_still_is_named_and_its_rows_kept_where_the_rate_is_steady(rate, first, equal):
    stamps = even(150, rate, begin=3.0)
    stood = stamps.copy()
    stood[first : first + equal] = stamps[first]
    found = checked(stood, "the rows")
    [note] = found.notes
    assert f"{equal} samples from sample {first + 1} on have the same stamp" in note
    np.testing.assert_allclose(found.stamps, stamps, atol=1e-6)
    lost = stood.copy()
    lost[first + equal :] += 3.0 * equal / rate  # and then a pause: when they came is not known
    found = checked(lost, "the rows")
    assert "not certain" in found.notes[0]
    np.testing.assert_array_equal(found.stamps, lost)


def test_a_pause_of_minutes_is_named_as_a_pause_or_a_clock_that_was_set_forward():
    stamps = even(100, 20.0)
    stamps[50:] += 3600.0
    found = checked(stamps, "the rows")
    assert "nothing for 3.6e+03 s before sample 51 of 100" in found.notes[0]
    np.testing.assert_array_equal(found.stamps, stamps)
