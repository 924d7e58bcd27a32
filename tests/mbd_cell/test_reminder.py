"""The teacher reminds whoever missed a word soon, and nags nobody who takes his time."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st
from mbd_cell.teacher.reminder import LONGEST, Reminder


@given(st.floats(0.5, 60.0), st.floats(0.0, 1e5))
def test_the_first_repetition_comes_after_the_first_wait_and_each_later_one_after_a_longer_up_to_a_minute(
    first: float, begun: float
):
    reminder = Reminder(first)
    reminder.said(begun)
    waits, since = [], begun
    for number in range(1, 3000):
        if reminder.due(begun + number * 0.25):
            waits.append(begun + number * 0.25 - since)
            since += waits[-1]
    assert reminder.repeated == len(waits)
    assert first <= waits[0] + 1e-6 <= first + 0.26
    assert all(b >= a - 0.26 for a, b in pairwise(waits))
    assert max(waits) <= LONGEST + 0.26


def test_a_new_word_is_repeated_soon_again():
    reminder = Reminder(3.0)
    reminder.said(0.0)
    assert [t for t in range(1, 30) if reminder.due(t)] == [3, 9, 21]
    reminder.said(30.0)
    assert [t for t in range(31, 40) if reminder.due(t)] == [33, 39]
