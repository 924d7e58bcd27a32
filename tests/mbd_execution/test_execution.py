"""Execution, as a value: grasps, places, retries, corrections, putting back, going on after a restart."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_cell.arm.kinematics import DownwardToolPose
from mbd_execution.choosing import may_be_stopped, next_motion
from mbd_execution.execution import Work, assisted_again, begin, interrupted, motion_ended, progress
from mbd_execution.goals import Ended, Grip, MoveTo, ToolGoal, goal_of
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_execution.resume import resumed
from mbd_execution.synthetic import blocks, demonstration, obeys, play
from mbd_model.execution_progress import Purpose, Status
from mbd_model.objects import Role
from mbd_model.stop import MotionError
from scipy.spatial.transform import Rotation

HAND = HandConfig()
SMALL = {"1": (0.04, 0.04, 0.06), "2": (0.08, 0.08, 0.06), "3": (0.05, 0.05, 0.05)}
TARGET = {"1": (0.05, 0.05, 0.07), "2": (0.09, 0.09, 0.05), "3": (0.04, 0.04, 0.04)}
MAPPING = {"s1": "t1", "s2": "t2", "s3": "t3"}
STACK = [("s1", "s2", (0.0, 0.0)), ("s3", "s1", (0.0, 0.0))]


def stack(mapping: dict[str, str] | None = None) -> Work:
    task = demonstration(blocks(Role.SOURCE, "s", SMALL), STACK)
    target = blocks(Role.TARGET, "t", TARGET, yaw=0.3)
    return begin(plan(task, target, MAPPING if mapping is None else mapping), HAND)


def where(work: Work, object_id: str) -> tuple[float, float, float]:
    return work.table[object_id].centroid


def test_every_step_is_done_in_order_and_the_objects_are_believed_where_they_were_put():
    work, _ = play(stack(), obeys)
    assert work.finished and progress(work).status is Status.FINISHED
    assert work.statuses == (Status.DONE,) * 4
    assert where(work, "t1") == pytest.approx((*where(work, "t2")[:2], 0.05 + 0.035), abs=1e-6)
    assert where(work, "t3") == pytest.approx((*where(work, "t2")[:2], 0.05 + 0.07 + 0.02), abs=1e-6)


def test_the_tool_travels_sideways_only_above_everything_and_what_it_carries():
    work = stack()
    tool = None
    while True:
        work, motion = next_motion(work, allowed=True)
        if motion is None:
            break
        if isinstance(motion, MoveTo):
            if tool is not None and math.dist((tool.x, tool.y), (motion.goal.x, motion.goal.y)) > 0.001:
                carried = work.carried.held.box.object_id if work.carried else ""
                hanging = work.carried.held.below_tool if work.carried else HAND.fingertip_drop
                tops = [o.centroid[2] + o.size[2] / 2 for o in work.table.objects if o.object_id != carried]
                assert min(tool.z, motion.goal.z) - hanging >= max(tops) + 0.04
            tool = motion.goal
        work = motion_ended(work, obeys(motion, work))


@given(scale=st.floats(0.6, 1.4), share=st.floats(0.25, 0.4), yaw=st.floats(-0.5, 0.5))
@settings(max_examples=40)
def test_an_offset_keeps_its_share_of_the_box_it_is_measured_in(scale: float, share: float, yaw: float):
    """A block at the edge of a long tray, on a tray of another size that lies turned."""
    source = blocks(Role.SOURCE, "s", {"1": (0.03, 0.03, 0.04), "2": (0.16, 0.26, 0.02)})
    task = demonstration(source, [("s1", "s2", (share * 0.26, 0.0))])
    target = blocks(Role.TARGET, "t", {"1": (0.03, 0.03, 0.04), "2": (0.16 * scale, 0.26 * scale, 0.02)}, yaw)
    work, _ = play(begin(plan(task, target, MAPPING), HAND), obeys)
    dx = where(work, "t1")[0] - where(work, "t2")[0]
    dy = where(work, "t1")[1] - where(work, "t2")[1]
    along = share * 0.26 * scale
    assert (dx, dy) == pytest.approx((along * math.cos(yaw), along * math.sin(yaw)), abs=1e-6)


def test_what_no_hand_spans_is_taken_by_its_rim():
    source = blocks(Role.SOURCE, "s", SMALL)
    target = blocks(Role.TARGET, "t", {**TARGET, "1": (0.12, 0.12, 0.05)})
    task = demonstration(source, STACK[:1])
    _, motions = play(begin(plan(task, target, MAPPING), HAND), obeys)
    grasp = next(m for m, after in itertools.pairwise(motions) if after == Grip(close=True))
    middle = target["t1"].centroid
    assert isinstance(grasp, MoveTo)
    assert math.dist((grasp.goal.x, grasp.goal.y), middle[:2]) == pytest.approx(0.06 - HAND.rim_in)


@given(st.floats(-3.1, 3.1), st.floats(-0.5, 0.5))
def test_a_tilted_goal_is_the_pose_it_states_and_the_cell_takes_it_as_that(yaw: float, tilt: float):
    goal = ToolGoal(0.4, 0.1, 0.2, yaw, tilt)
    turned = Rotation.from_quat(goal.quaternion).as_matrix()
    assert turned == pytest.approx(DownwardToolPose(0.4, 0.1, 0.2, yaw, tilt).rotation, abs=1e-9)
    back = goal_of((0.4, 0.1, 0.2), goal.quaternion)
    assert (back.yaw, back.tilt) == pytest.approx((yaw, tilt), abs=1e-9)


def test_a_bowl_is_taken_with_the_hand_along_its_wall_and_set_down_as_level_as_it_was():
    source = blocks(Role.SOURCE, "s", SMALL)
    target = blocks(Role.TARGET, "t", {**TARGET, "1": (0.12, 0.12, 0.05)})
    bowl = tuple(replace(o, object_class="bowl") if o.object_id == "t1" else o for o in target.objects)
    task = demonstration(source, STACK[:1])
    work = begin(plan(task, replace(target, objects=bowl), MAPPING), HAND, looks=True)
    _, motions = play(work, obeys)
    closed = motions.index(Grip(close=True))
    opened = motions.index(Grip(close=False), closed)
    carried = [m.goal.tilt for m in motions[closed - 1 : opened] if isinstance(m, MoveTo)]
    assert carried and set(carried) == {HAND.rim_tilt}


def test_what_fits_between_closed_fingertips_is_pushed_by_two_against_the_third_and_farther_the_second_time():
    """A spoon: the tool is off its axis towards finger 1, on the tool's -y side, and as low as the fingers may go."""
    source = blocks(Role.SOURCE, "s", SMALL)
    target = blocks(Role.TARGET, "t", {**TARGET, "1": (0.018, 0.15, 0.016)}, yaw=0.3)
    work = begin(plan(demonstration(source, STACK[:1]), target, MAPPING), HAND)
    goals = []

    def slips(motion, work):
        if motion == Grip(close=True):
            goals.append(work.course.goal)
            return Ended(True, holding=False)
        return obeys(motion, work)

    play(work, slips)
    x, y, z = target["t1"].centroid
    assert len(goals) == 3
    for goal, shift in zip(goals, (HAND.thin_shift, 2 * HAND.thin_shift), strict=False):
        outwards = (-math.sin(goal.yaw), math.cos(goal.yaw))
        assert (goal.x - x, goal.y - y) == pytest.approx((shift * outwards[0], shift * outwards[1]), abs=1e-9)
        assert goal.z == pytest.approx(z - 0.008 + HAND.fingertip_drop + HAND.table_gap)


def test_a_failed_grasp_is_tried_three_times_and_then_asked_about():
    grips = []

    def slips(motion, work):
        if motion == Grip(close=True):
            grips.append(work.course.transfer.held)
            return Ended(True, holding=False)
        return obeys(motion, work)

    work, motions = play(stack(), slips)
    assert grips == ["t1", "t1", "t1"]
    assert progress(work).status is Status.FAILED and progress(work).step_index == 0
    assert motions[-2] == Grip(close=False)
    assert next_motion(work, allowed=True)[1] is None


def test_a_grasp_that_succeeds_the_second_time_is_no_failure():
    tries = []

    def slips_once(motion, work):
        if motion == Grip(close=True):
            tries.append(1)
            return Ended(True, holding=len(tries) != 1)
        return obeys(motion, work)

    assert play(stack(), slips_once)[0].finished


def failed_at_first() -> Work:
    return play(stack(), lambda m, w: Ended(True, holding=False) if m == Grip(close=True) else obeys(m, w))[0]


def test_an_answer_makes_the_robot_try_a_failed_step_again():
    failed = failed_at_first()
    work, _ = play(assisted_again(failed, failed.plan, frozenset({"s1"})), obeys)
    assert work.finished and work.statuses == (Status.DONE,) * 4


def test_a_failed_step_nobody_answers_for_is_left_out_and_reported():
    failed = failed_at_first()
    work, _ = play(assisted_again(failed, failed.plan, frozenset()), obeys)
    assert work.finished
    assert work.statuses == (Status.LEFT_OUT, Status.LEFT_OUT, Status.DONE, Status.DONE)
    assert "but for step 1 and 2" in progress(work).text


def test_an_object_without_a_counterpart_is_asked_about_before_anything_moves():
    work, motions = play(stack({"s1": "t1", "s3": "t3"}), obeys)
    assert motions == []
    assert progress(work).status is Status.FAILED and progress(work).step_index == 1
    assert "s2" in progress(work).text


def until_carried(work: Work) -> Work:
    while work.carried is None:
        work, motion = next_motion(work, allowed=True)
        work = motion_ended(work, obeys(motion, work))
    return work


def test_a_robot_asked_to_stop_puts_back_what_it_holds_and_then_rests():
    work = until_carried(stack())
    before = stack().table["t1"].centroid
    work, motion = next_motion(work, allowed=True)
    assert may_be_stopped(work)
    work = interrupted(work, motion.goal)
    acts = set()
    while True:
        work, motion = next_motion(work, allowed=False)
        if motion is None:
            break
        acts.add(work.course.purpose)
        work = motion_ended(work, obeys(motion, work))
    assert acts == {Purpose.RETURN}
    assert work.carried is None
    assert where(work, "t1") == pytest.approx(before, abs=1e-6)
    assert work.statuses == (Status.PLANNED,) * 4


def test_a_paused_robot_goes_on_with_what_it_holds():
    work = until_carried(stack())
    work = interrupted(work, None)
    assert play(work, obeys)[0].finished


def test_a_correction_puts_wrongly_placed_objects_back_last_first_and_does_it_right():
    work, _ = play(stack({"s1": "t3", "s2": "t2", "s3": "t1"}), obeys)
    fetched = []

    def watch(motion, now):
        if now.course.purpose is Purpose.FETCH and motion == Grip(close=True):
            fetched.append(now.course.transfer.held)
        return obeys(motion, now)

    work, _ = play(assisted_again(work, stack().plan, frozenset({"s1"})), watch)
    assert fetched == ["t1", "t3"]
    assert work.finished
    right = play(stack(), obeys)[0]
    for name in ("t1", "t2", "t3"):
        assert where(work, name) == pytest.approx(where(right, name), abs=1e-6)


def test_a_correction_that_changes_nothing_done_moves_nothing():
    work, _ = play(stack(), obeys)
    assert play(assisted_again(work, work.plan, frozenset()), obeys)[1] == []


@pytest.mark.parametrize("motions", range(0, 33, 4))
def test_work_resumed_from_its_statuses_ends_as_if_it_had_never_stopped(motions: int):
    work = stack()
    for _ in range(motions):
        work, motion = next_motion(work, allowed=True)
        if motion is None:
            break
        work = motion_ended(work, obeys(motion, work))
    again, _ = play(resumed(work.plan, HAND, work.statuses), obeys)
    complete, _ = play(stack(), obeys)
    assert again.finished and again.statuses == complete.statuses
    for name in ("t1", "t2", "t3"):
        assert where(again, name) == pytest.approx(where(complete, name), abs=1e-6)


def test_a_place_on_the_table_that_is_taken_moves_to_the_nearest_free_one():
    source = blocks(Role.SOURCE, "s", SMALL)
    task = demonstration(source, [("s1", None, (0.45, 0.0))])
    target = blocks(Role.TARGET, "t", TARGET)
    taken = target["t2"].centroid
    work, _ = play(begin(plan(task, target, MAPPING), HAND), obeys)
    assert taken[:2] == (0.45, 0.0)
    assert 0.06 < math.dist(where(work, "t1")[:2], taken[:2]) < 0.12


def test_a_hand_that_closes_is_not_stopped_halfway():
    work = stack()
    while True:
        work, motion = next_motion(work, allowed=True)
        if motion == Grip(close=True):
            break
        work = motion_ended(work, obeys(motion, work))
    assert not may_be_stopped(work)


def test_an_unreachable_place_sends_the_object_back_and_is_asked_about():
    work = until_carried(stack())
    place = replace(work)

    def short(motion, now):
        if now.course.purpose is Purpose.PLACE and isinstance(motion, MoveTo):
            return Ended(False, message="out of reach", error=MotionError.NOT_REACHED)
        return obeys(motion, now)

    work, _ = play(place, short)
    assert progress(work).status is Status.FAILED and progress(work).step_index == 1
    assert work.carried is None
    assert where(work, "t1") == pytest.approx(stack().table["t1"].centroid, abs=1e-6)
