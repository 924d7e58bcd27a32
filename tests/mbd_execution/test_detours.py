"""Ways across the table: round what is too high, never over the teacher's hands, or asked about."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from mbd_execution.detours import Load, NoWayError, way_across, zone
from mbd_execution.execution import assisted_again, begin, progress
from mbd_execution.goals import MoveTo, ToolGoal
from mbd_execution.hand import HandConfig
from mbd_execution.parameters import EXECUTION, hand_config
from mbd_execution.plan import plan
from mbd_execution.synthetic import blocks, demonstration, obeys, play
from mbd_model.execution_progress import Failure, Status, Verdict
from mbd_model.objects import Role, SceneObject
from mbd_model.parameters import ParameterError

HAND = HandConfig(hand_zone=(0.40, 0.50, -0.05, 0.05))
places = st.tuples(st.floats(0.25, 0.62), st.floats(-0.3, 0.3))


def sampled(start: tuple[float, float], way: tuple[tuple[float, float], ...]):
    for one, other in zip((start, *way), way, strict=False):
        for k in range(51):
            yield one[0] + (other[0] - one[0]) * k / 50, one[1] + (other[1] - one[1]) * k / 50


def across(start, goal, others=(), hand=HAND):
    begin, end = ToolGoal(*start, 0.35, 0.0), ToolGoal(*goal, 0.35, 0.0)
    return way_across(begin, end, 0.35, load=Load(0.1), others=others, hand=hand)


def tower(x: float, y: float, yaw: float = 0.0) -> SceneObject:
    return SceneObject("tower", (x, y, 0.2), (0.08, 0.12, 0.4), yaw=yaw)


@given(start=places, goal=places)
def test_no_way_passes_over_the_hands_and_a_free_straight_way_is_taken(start, goal):
    hands = zone(HAND, HAND.hand_radius)
    assume(not hands.inside(start) and not hands.inside(goal))
    way = across(start, goal, (), HAND)
    assert way[-1] == goal
    assert not any(hands.inside(p) for p in sampled(start, way))
    if not hands.crossed(start, goal):
        assert way == (goal,)


@given(start=places, goal=places, yaw=st.floats(-1.5, 1.5))
@example(start=(0.6171875, 0.0), goal=(0.25, 0.0), yaw=0.75)
def test_what_is_too_high_to_be_passed_over_is_passed_by(start, goal, yaw):
    hand = HandConfig()
    thing = tower(0.45, 0.0, yaw)
    over = (math.hypot(0.06, 0.04), (0.45, 0.0))
    assume(math.dist(start, over[1]) > over[0] and math.dist(goal, over[1]) > over[0])
    way = way_across(
        ToolGoal(*start, 0.35, 0.0), ToolGoal(*goal, 0.35, 0.0), 0.35, load=Load(0.1), others=(thing,), hand=hand
    )
    for x, y in sampled(start, way):
        c, s = math.cos(-yaw), math.sin(-yaw)
        u, v = c * (x - 0.45) - s * y, s * (x - 0.45) + c * y
        assert abs(u) >= 0.06 or abs(v) >= 0.04
    low = replace(thing, centroid=(0.45, 0.0, 0.05), size=(0.08, 0.12, 0.1))
    assert way_across(
        ToolGoal(*start, 0.35, 0.0), ToolGoal(*goal, 0.35, 0.0), 0.35, load=Load(0.1), others=(low,), hand=hand
    ) == (goal,)


def test_where_everything_is_blocked_there_is_no_way():
    hand = HandConfig(hand_zone=(-1.0, 1.0, -0.05, 0.05))
    with pytest.raises(NoWayError) as error:
        way_across(
            ToolGoal(0.4, 0.3, 0.3, 0.0), ToolGoal(0.4, -0.3, 0.3, 0.0), 0.3, load=Load(0.1), others=(), hand=hand
        )
    assert error.value.failure is Failure.HAND_ZONE


def test_a_complete_task_is_done_round_the_hands():
    sizes = {"1": (0.04, 0.04, 0.06), "2": (0.08, 0.08, 0.06), "3": (0.05, 0.05, 0.05)}
    task = demonstration(blocks(Role.SOURCE, "s", sizes), [("s1", "s3", (0.0, 0.0))])
    hand = HandConfig(hand_zone=(0.43, 0.47, -0.03, 0.03))
    work = begin(plan(task, blocks(Role.TARGET, "t", sizes), {"s1": "t1", "s3": "t3"}), hand, looks=True)
    work, motions = play(work, obeys)
    assert work.finished
    hands, tool = zone(hand, 0.0), None
    for motion in motions:
        if isinstance(motion, MoveTo):
            now = (motion.goal.x, motion.goal.y)
            assert tool is None or not hands.crossed(tool, now)
            tool = now


def test_an_object_among_the_hands_is_asked_about_and_taken_once_it_is_out_of_there():
    sizes = {"1": (0.04, 0.04, 0.06), "2": (0.08, 0.08, 0.06), "3": (0.05, 0.05, 0.05)}
    task = demonstration(blocks(Role.SOURCE, "s", sizes), [("s2", "s3", (0.0, 0.0))])
    hand = HandConfig(hand_zone=(0.40, 0.50, -0.05, 0.05))  # t2 stands there
    work = begin(plan(task, blocks(Role.TARGET, "t", sizes), {"s2": "t2", "s3": "t3"}), hand)
    work, motions = play(work, obeys)
    assert motions == []
    now = progress(work)
    assert (now.status, now.failure) == (Status.FAILED, Failure.HAND_ZONE) and "your hands" in now.text
    moved = replace(work, hand=HandConfig())
    work, _ = play(assisted_again(moved, work.plan, frozenset(), Verdict.YES), obeys)
    assert work.finished


@pytest.mark.parametrize("given", [[0.5, 0.4, 0.0, 0.1], [0.1, 0.2, 0.3], [0.0, math.nan, 0.0, 0.1]])
def test_a_zone_that_is_none_is_refused(given: list[float]):
    with pytest.raises(ParameterError, match="hand_zone"):
        hand_config(EXECUTION.values() | {"hand_zone": given})
