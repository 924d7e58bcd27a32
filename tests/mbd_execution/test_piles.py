"""What a look says of objects that stand on each other when perception sees them as one, or in pieces."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_execution.boxes import top
from mbd_execution.demonstrated_transfers import standing
from mbd_execution.looking.changes import TableChange, look
from mbd_model.objects import Role, Scene, SceneObject

PLACE = (0.45, -0.2)
BESIDE = SceneObject("other", (0.3, 0.2, 0.04), (0.07, 0.07, 0.08), hue=200.0, saturation=0.8)


def box(name: str, place: tuple[float, float], base: float, size: tuple[float, float, float], **more) -> SceneObject:
    middle = (*place, base + size[2] / 2)
    return SceneObject(name, middle, size, box_center=middle, saturation=0.8, **more)


def believed(*things: SceneObject) -> TrackedObjects:
    """A table with a pile of those, each on the one before, and one object beside."""
    table = standing(Scene(Role.TARGET, (*things, BESIDE)))
    for lower, upper in itertools.pairwise(things):
        table = table.put_onto(upper.object_id, lower.object_id)
    return table


def tower(heights: list[float], widest: float) -> list[SceneObject]:
    """Cups on each other, each narrower than the one below."""
    cups, base = [], 0.0
    for k, height in enumerate(heights):
        side = widest - 0.008 * k
        cups.append(box(f"t{k}", PLACE, base, (side, side, height), hue=(80.0 * k + 10) % 360))
        base += height
    return cups


def melted(*things: SceneObject, yaw: float = 0.0, off: tuple[float, float] = (0.0, 0.0)) -> SceneObject:
    """What is seen of some objects that touch: one box from the table to the highest top, of a color of its own."""
    width, height = max(max(t.size[:2]) for t in things), max(top(t) for t in things)
    place = (things[0].centroid[0] + off[0], things[0].centroid[1] + off[1])
    return box("melted", place, 0.0, (width * 0.95, width, height), hue=155.0, yaw=yaw)


def scene(*objects: SceneObject) -> Scene:
    return Scene(Role.TARGET, tuple(replace(o, object_id=f"seen{k}") for k, o in enumerate((*objects, BESIDE))))


heights = st.lists(st.floats(0.04, 0.1), min_size=2, max_size=4)
widest = st.floats(0.06, 0.08)
noise = st.tuples(st.floats(-0.008, 0.008), st.floats(-0.008, 0.008))
yaw = st.floats(-math.pi, math.pi)


@given(heights, widest, noise, yaw, st.integers(1, 4))
@settings(deadline=None)
def test_a_tower_seen_as_one_or_as_two_that_reaches_as_high_as_it_should_stands(heights, widest, noise, yaw, lower):
    cups = tower(heights, widest)
    pieces = [melted(*cups, yaw=yaw, off=noise)]
    if lower < len(cups):
        pieces.append(melted(*cups[:lower], yaw=-yaw, off=(-noise[1], noise[0])))
    looked = look(believed(*cups), scene(*pieces))
    assert looked.differences == () and not looked.gone and not looked.new
    assert all(math.dist(looked.table[c.object_id].centroid, c.centroid) < 0.02 for c in cups)


@given(heights, widest, noise, yaw, st.integers(1, 3))
@settings(deadline=None)
def test_what_is_missing_from_the_top_of_a_tower_is_gone_though_the_rest_is_seen_as_one(
    heights, widest, noise, yaw, left
):
    cups = tower(heights, widest)
    left = min(left, len(cups) - 1)
    looked = look(believed(*cups), scene(melted(*cups[:left], yaw=yaw, off=noise)))
    assert looked.gone == {c.object_id for c in cups[left:]}


@given(heights, widest, st.floats(0.03, 0.06), st.floats(0, 2 * math.pi), yaw)
@settings(deadline=None)
def test_a_tower_that_was_pushed_is_followed_as_a_whole(heights, widest, far, angle, yaw):
    cups = tower(heights, widest)
    off = (far * math.cos(angle), far * math.sin(angle))
    looked = look(believed(*cups), scene(melted(*cups, yaw=yaw, off=off)))
    assert not looked.gone and not looked.new
    for cup in cups:
        x, y, _ = looked.table[cup.object_id].centroid
        assert math.dist((x, y), (PLACE[0] + off[0], PLACE[1] + off[1])) < 0.02
    assert len(looked.table.rests_on) == len(cups) - 1


def test_a_cup_that_slid_off_a_tower_stands_beside_it_and_is_seen_there():
    cups = tower([0.09, 0.08, 0.07], 0.07)
    beside = box("x", (PLACE[0] + 0.07, PLACE[1] + 0.06), 0.0, cups[2].size, hue=cups[2].hue)
    looked = look(believed(*cups), scene(melted(*cups[:2]), beside))
    assert [(d.change, d.object_id) for d in looked.differences] == [(TableChange.MOVED, "t2")]
    assert ("t2", "t1") not in looked.table.rests_on and ("t1", "t0") in looked.table.rests_on


@given(yaw, noise)
def test_a_fork_across_a_bowl_is_there_as_long_as_the_two_reach_above_the_rim(angle, noise):
    bowl = box("t0", PLACE, 0.0, (0.107, 0.106, 0.048), hue=240.0)
    fork = box("t1", PLACE, 0.048, (0.02, 0.143, 0.015), hue=357.0, yaw=angle)
    across = replace(melted(bowl, fork, yaw=angle + 1.0, off=noise), size=(0.107, 0.12, 0.063))
    assert not look(believed(bowl, fork), scene(across)).gone
    assert look(believed(bowl, fork), scene(replace(bowl, hue=238.0))).gone == {"t1"}


def test_a_block_seen_as_one_with_the_block_it_lies_on_lies_there():
    """Seen in a trial of assembly, even seed: the upper block was taken to be gone, and its place to be higher."""
    lower = box("t0", PLACE, 0.0, (0.087, 0.054, 0.038), hue=322.0)
    upper = box("t1", PLACE, 0.038, (0.063, 0.038, 0.028), hue=19.0)
    both = box("seen", PLACE, 0.0, (0.087, 0.053, 0.065), hue=354.0)
    looked = look(believed(lower, upper), scene(both))
    assert looked.differences == () and not looked.gone
    assert looked.table["t0"].centroid == lower.centroid


def test_what_is_under_a_cup_that_slid_off_stays_where_it_is():
    """Seen in a trial of stacking: the complete tower was believed where its top had come to stand."""
    cups = tower([0.09, 0.08, 0.07], 0.07)
    beside = box("x", (PLACE[0] + 0.03, PLACE[1] - 0.1), 0.0, cups[2].size, hue=cups[2].hue)
    half = replace(cups[1], centroid=(PLACE[0], PLACE[1] + 0.02, 0.08), size=(0.02, 0.06, 0.16))
    looked = look(believed(*cups), scene(replace(half, box_center=half.centroid), beside))
    for cup in cups[:2]:
        assert math.dist(looked.table[cup.object_id].centroid[:2], PLACE) < 0.02


def test_a_covered_cup_is_not_taken_along_by_one_that_came_to_rest_a_little_beside_the_middle():
    cups = tower([0.092, 0.082], 0.07)
    upper = replace(cups[1], centroid=(PLACE[0], PLACE[1] - 0.018, 0.086), size=(0.06, 0.06, 0.172))
    part = replace(cups[0], centroid=(PLACE[0] + 0.003, PLACE[1] + 0.014, 0.047), size=(0.04, 0.07, 0.095))
    seen = scene(*(replace(s, box_center=s.centroid) for s in (upper, part)))
    looked = look(believed(*cups), seen)
    assert looked.table["t0"].centroid[:2] == PLACE


def test_the_middle_of_a_fork_and_half_a_bowl_is_not_where_the_fork_is():
    """Seen in a trial of dish sorting: the fork was 23 mm beside where it had been put, and asked about."""
    bowl = box("t0", (0.565, -0.066), 0.0, (0.117, 0.12, 0.051), hue=334.0)
    fork = box("t1", (0.565, -0.066), 0.0505, (0.161, 0.022, 0.017), hue=236.0, yaw=0.6)
    with_half = box("x", (0.584, -0.053), 0.0, (0.157, 0.074, 0.067), hue=308.0, yaw=0.6)
    half = box("y", (0.535, -0.088), 0.0, (0.115, 0.046, 0.051), hue=334.0, yaw=0.6)
    looked = look(believed(bowl, fork), scene(with_half, half))
    assert looked.differences == ()
    assert looked.table["t1"].centroid == fork.centroid
