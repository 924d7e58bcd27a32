"""The timeline keeps every event apart and in order, names every phase however short, and says how long a wait was."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_bag.storage.bag import Bag
from mbd_model.times import to_seconds
from mbd_study.figures.time_axis import TimeAxis
from mbd_study.figures.timeline import clock_text, timeline_legend, timeline_svg
from mbd_study.tables.events import EventRow, event_rows

BAG = Path(__file__).resolve().parents[2] / "bags" / "stacking_undo"
WAIT = 1150.0


@pytest.fixture(scope="module")
def rows() -> tuple[EventRow, ...]:
    """Twenty minutes, of which the demonstration takes all but half a minute."""
    return tuple(replace(r, time_s=r.time_s + WAIT * (r.time_s > 40)) for r in event_rows(Bag(BAG), "s"))


@pytest.fixture(scope="module")
def svg(rows: tuple[EventRow, ...]) -> str:
    bag = Bag(BAG)
    return timeline_svg(rows, to_seconds(bag.end - bag.start) + WAIT)


@settings(deadline=None)
@given(st.lists(st.floats(0, 5000) | st.just(7.0), min_size=1, max_size=80), st.data())
def test_moments_are_in_order_and_apart_whatever_their_times(times: list[float], data: st.DataObject):
    times = sorted(times)
    named = sorted(data.draw(st.sets(st.integers(0, len(times) - 1), max_size=8)))
    axis = TimeAxis(times, [(k, 100.0) for k in named], 840)
    places = [axis.place_of(k) for k in range(len(times))]
    assert all(0 <= p.x <= 840 + 1e-6 for p in places)
    assert [p.row for p in places] == sorted(p.row for p in places)
    assert axis.rows == places[-1].row + 1
    assert all(b.x - a.x >= 10 for a, b in pairwise(places) if a.row == b.row)


def test_each_event_has_one_mark_and_marks_of_one_line_are_apart_and_in_the_bags_order(
    rows: tuple[EventRow, ...], svg: str
):
    marks = [(float(x), float(y)) for x, y in re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)"', svg)]
    assert len(marks) == sum(r.kind != "phase" for r in rows)
    places = [(y // 176, x) for x, y in ((x, y - 58) for x, y in marks)]
    assert places == sorted(places)
    assert all(b[1] - a[1] >= 10 for a, b in pairwise(places) if a[0] == b[0])


def test_each_phase_has_room_for_its_name_though_it_lasts_a_second_of_twenty_minutes(
    rows: tuple[EventRow, ...], svg: str
):
    for row in rows:
        if row.kind == "phase":
            assert re.search(rf"<text [^>]*>{row.name.replace('_', ' ')}</text>", svg)
    assert "20:00" in svg


def test_a_wait_that_is_cut_states_its_length(rows: tuple[EventRow, ...], svg: str):
    longest = max(b.time_s - a.time_s for a, b in pairwise(rows))
    assert longest > WAIT
    assert svg.count('class="cut"') == 1
    assert clock_text(longest) in svg


def test_an_estimate_is_shown_as_it_was_published_whatever_its_confidence(rows: tuple[EventRow, ...]):
    made = [replace(r, name=name, text="0.9999") for r in rows[:1] for name in ("confident", "not_sure")]
    made = [replace(r, kind="estimate", topic="mapping/estimate") for r in made]
    svg = timeline_svg(made, 10.0)
    assert svg.count("published as confident") == svg.count("published as not sure") == 1
    colors = re.findall(r'<circle [^>]*fill="(#\w+)"', svg)
    assert len(set(colors)) == 2
    legend = timeline_legend(made)
    assert re.search(rf'{colors[0]}"></i>confident', legend)
    assert re.search(rf'{colors[1]}"></i>not sure', legend)
