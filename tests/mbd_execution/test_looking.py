"""Which object is which when the table is looked at again, and what is noticed to have changed."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_execution.demonstrated_transfers import standing
from mbd_execution.looking.changes import TableChange, look
from mbd_execution.looking.expected import Expected
from mbd_execution.looking.likeness import log_odds
from mbd_model.objects import Role, Scene, SceneObject

PLACES = ((0.3, -0.25), (0.3, 0.0), (0.3, 0.25), (0.55, -0.2), (0.55, 0.1))
HUES = (5.0, 120.0, 230.0, 120.0, 60.0)
SIDES = ((0.06, 0.06, 0.08), (0.05, 0.05, 0.07), (0.08, 0.07, 0.05), (0.06, 0.06, 0.09), (0.12, 0.12, 0.05))


def thing(number: int, place: tuple[float, float], size=None, hue=None) -> SceneObject:
    size = size or SIDES[number]
    middle = (*place, size[2] / 2)
    hue = HUES[number] if hue is None else hue
    return SceneObject(f"t{number}", middle, size, hue=hue, saturation=0.8, box_center=middle)


def scene(*objects: SceneObject) -> Scene:
    return Scene(Role.TARGET, tuple(replace(o, object_id=f"seen{k}") for k, o in enumerate(objects)))


THINGS = tuple(thing(k, place) for k, place in enumerate(PLACES))
TABLE = standing(Scene(Role.TARGET, THINGS))


def at(table: TrackedObjects, name: str) -> tuple[float, float]:
    return table[name].centroid[:2]


def test_a_table_nobody_touched_has_not_changed():
    looked = look(TABLE, scene(*THINGS))
    assert looked.differences == () and not looked.gone and not looked.new


@given(
    noise=st.lists(st.tuples(*[st.floats(-0.008, 0.008)] * 2, st.floats(-5.0, 5.0)), min_size=5, max_size=5),
    order=st.permutations(range(5)),
    pushed=st.integers(0, 4),
    angle=st.floats(0, 2 * math.pi),
)
@settings(max_examples=60)
def test_what_was_pushed_by_5_cm_keeps_its_name_in_any_order_and_with_noise(noise, order, pushed, angle):
    now = []
    for k, (dx, dy, turn) in enumerate(noise):
        x, y = PLACES[k]
        if k == pushed:
            x, y = x + 0.05 * math.cos(angle), y + 0.05 * math.sin(angle)
        now.append(thing(k, (x + dx, y + dy), hue=(HUES[k] + turn) % 360))
    looked = look(TABLE, scene(*(now[k] for k in order)))
    for k in range(5):
        assert at(looked.table, f"t{k}") == now[k].centroid[:2]
    assert {d.change for d in looked.differences} <= {TableChange.MOVED}
    assert [d.object_id for d in looked.differences] == [f"t{pushed}"]


def test_what_is_taken_away_is_gone_and_nothing_else_takes_its_name():
    looked = look(TABLE, scene(*THINGS[:1], *THINGS[2:]))
    assert looked.gone == {"t1"} and [d.change for d in looked.differences] == [TableChange.GONE]


def test_what_is_put_there_is_new_and_said_to_look_like_another():
    stranger = thing(0, (0.5, 0.3))
    looked = look(TABLE, scene(*THINGS, stranger))
    (new,) = looked.differences
    assert new.change is TableChange.NEW and new.other == "t0" and looked.new == {new.object_id}
    assert look(looked.table, scene(*THINGS, stranger)).differences == ()


def test_two_that_look_alike_but_for_a_little_are_noticed_when_they_change_places():
    one, other = thing(1, PLACES[3], hue=118.0), thing(3, PLACES[1])
    looked = look(TABLE, scene(THINGS[0], other, THINGS[2], one, THINGS[4]))
    noticed = {d.object_id: d for d in looked.differences}
    assert set(noticed) == {"t1", "t3"}
    for difference in noticed.values():
        assert difference.change in (TableChange.SWAPPED, TableChange.UNSURE)
        assert difference.otherwise is not None
        places = {at(difference.otherwise, difference.object_id), at(looked.table, difference.object_id)}
        assert places == {PLACES[1], PLACES[3]}


def test_two_of_different_color_that_change_places_keep_their_names_and_are_noticed():
    looked = look(TABLE, scene(thing(0, PLACES[2]), THINGS[1], thing(2, PLACES[0]), *THINGS[3:]))
    assert at(looked.table, "t0") == PLACES[2] and at(looked.table, "t2") == PLACES[0]
    assert {(d.change, d.object_id, d.other) for d in looked.differences} == {
        (TableChange.SWAPPED, "t0", "t2"),
        (TableChange.SWAPPED, "t2", "t0"),
    }
    assert all(d.otherwise is None for d in looked.differences)  # nothing to choose: nobody takes red for blue


def test_what_was_knocked_over_is_still_itself_and_lies():
    lies = thing(3, (0.57, -0.18), size=(0.06, 0.09, 0.06))
    looked = look(TABLE, scene(*THINGS[:3], lies, THINGS[4]))
    assert [(d.change, d.object_id) for d in looked.differences] == [(TableChange.FALLEN, "t3")]


def test_what_is_in_another_may_be_unseen_and_moves_with_it():
    bowl = TABLE["t4"]
    small = replace(TABLE["t2"], centroid=(*bowl.centroid[:2], 0.02), size=(0.05, 0.05, 0.03))
    table = replace(TABLE, objects=(*(o for o in TABLE.objects if o.object_id != "t2"), small)).put_onto("t2", "t4")
    seen = (*THINGS[:2], THINGS[3], thing(4, (0.58, 0.14)))
    looked = look(table, scene(*seen))
    assert not looked.gone
    assert at(looked.table, "t2") == pytest.approx((0.58, 0.14)) and at(looked.table, "t4") == (0.58, 0.14)


def test_a_tower_whose_top_is_missing_has_lost_it():
    low, high = TABLE["t3"], replace(TABLE["t1"], centroid=(*PLACES[3], 0.09 + 0.035))
    table = replace(TABLE, objects=(TABLE["t0"], high, TABLE["t2"], low, TABLE["t4"])).put_onto("t1", "t3")
    fell = thing(1, (0.65, -0.3), size=(0.05, 0.07, 0.05))
    assert look(table, scene(THINGS[0], *THINGS[2:])).gone == {"t1"}
    looked = look(table, scene(THINGS[0], *THINGS[2:], fell))
    assert [(d.change, d.object_id) for d in looked.differences] == [(TableChange.FALLEN, "t1")]
    high_seen = replace(THINGS[1], box_center=(*PLACES[3], 0.08), size=(0.05, 0.05, 0.16))
    assert look(table, scene(THINGS[0], high_seen, *THINGS[2:])).differences == ()


@given(st.floats(0.0, 0.4), st.floats(0.0, 180.0), st.floats(0.5, 2.0))
def test_likeness_changes_gradually_and_falls_with_every_difference(apart: float, turn: float, scale: float):
    def of(apart: float, turn: float, scale: float) -> float:
        width, depth, height = SIDES[0]
        other = thing(0, (0.3, -0.25 + apart), (width * scale, depth * scale, height), (HUES[0] + turn) % 360)
        return log_odds(Expected(THINGS[0], 0.008), other)

    here = of(apart, turn, scale)
    assert of(apart + 0.01, turn, scale) <= here + 1e-9
    assert of(apart, min(turn + 2.0, 180.0), scale) <= here + 1e-9
    step = 1e-4
    assert abs(of(apart + step, turn, scale) - here) < 0.2
    assert abs(of(apart, min(turn + 0.1, 180.0), scale) - here) < 0.5


def test_what_stands_out_of_a_bowl_is_missed_when_the_two_are_no_higher_than_the_bowl():
    """Perception sees a cup in a bowl as one object, as high as the cup."""
    bowl = TABLE["t4"]
    cup = replace(TABLE["t1"], centroid=(*bowl.centroid[:2], 0.055), size=(0.05, 0.05, 0.09))
    table = replace(TABLE, objects=(*(o for o in TABLE.objects if o.object_id != "t1"), cup)).put_onto("t1", "t4")
    others = (THINGS[0], *THINGS[2:4])
    both = thing(4, PLACES[4], size=(0.12, 0.12, 0.1), hue=90.0)
    assert not look(table, scene(*others, both)).gone
    assert look(table, scene(*others, THINGS[4])).gone == {"t1"}
