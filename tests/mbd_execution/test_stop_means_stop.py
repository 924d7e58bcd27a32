"""After a stop no motion comes of the work, whatever happens meanwhile, until a person lets it go on."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_execution.choosing import next_motion
from mbd_execution.execution import Work, assisted_again, begin, halted, interrupted, motion_ended, progress, released
from mbd_execution.goals import Ended, Grip, Motion
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_execution.synthetic import blocks, demonstration, obeys, play
from mbd_model.execution_progress import Status
from mbd_model.objects import Role
from mbd_model.stop import MotionError

SIZES = {"1": (0.04, 0.04, 0.06), "2": (0.08, 0.08, 0.06), "3": (0.05, 0.05, 0.05)}
MAPPING = {"s1": "t1", "s2": "t2", "s3": "t3"}
STOPPING = [error for error in MotionError if error is not MotionError.NOT_REACHED]


def stack() -> Work:
    task = demonstration(blocks(Role.SOURCE, "s", SIZES), [("s1", "s2", (0, 0)), ("s3", "s1", (0, 0))])
    return begin(plan(task, blocks(Role.TARGET, "t", SIZES), MAPPING), HandConfig())


def after(motions: int) -> tuple[Work, Motion]:
    """The work with its motion of that number under way."""
    work, motion = next_motion(stack(), allowed=True)
    for _ in range(motions):
        assert motion is not None
        work, motion = next_motion(motion_ended(work, obeys(motion, work)), allowed=True)
    assert motion is not None
    return work, motion


@pytest.mark.parametrize("error", STOPPING)
@pytest.mark.parametrize("motions", range(26))
def test_a_failure_that_is_not_only_not_getting_there_is_followed_by_nothing(motions: int, error: MotionError):
    """../shared/cases/demonstration/estop: it was retried at once, and then the hand opened with the object in the air.

    The message is that of an arm in an emergency stop; its code counts, and so does having none.
    """
    work, _ = after(motions)
    holding = work.carried
    work = motion_ended(work, Ended(False, message="emergency stop", reached=work.tool, error=error))
    for allowed in (True, False):
        assert next_motion(work, allowed) == (work, None)
    assert work.carried == holding and work.failure is None and work.attempts == 0
    assert progress(work).status is Status.STOPPED and "emergency stop" in progress(work).text


@pytest.mark.parametrize("motions", range(26))
def test_let_go_on_by_a_person_the_work_is_done_as_if_it_had_never_stopped(motions: int):
    work, _ = after(motions)
    work = motion_ended(work, Ended(False, message="emergency stop", reached=work.tool))
    done, _ = play(released(work), obeys)
    assert done.finished and done.statuses == (Status.DONE,) * 4
    right = play(stack(), obeys)[0]
    for name in ("t1", "t2", "t3"):
        assert done.table[name].centroid == pytest.approx(right.table[name].centroid, abs=1e-6)


def test_what_is_held_is_not_let_go_first_after_a_stop_in_the_air():
    work, motion = after(0)
    while work.carried is None:
        work, motion = after_next(work, motion)
    work = released(motion_ended(work, Ended(False, message="protective stop")))
    motions = []
    while not motions or motions[-1] != Grip(close=False):
        work, motion = next_motion(work, allowed=True)
        assert motion is not None
        motions.append(motion)
        work = motion_ended(work, obeys(motion, work))
    assert len(motions) > 2  # over the goal and down to it


def after_next(work: Work, motion: Motion) -> tuple[Work, Motion]:
    work, following = next_motion(motion_ended(work, obeys(motion, work)), allowed=True)
    assert following is not None
    return work, following


EVENTS = st.sampled_from(["stop", "fail", "slip", "interrupt", "assist", "not allowed", "release", "go", "go", "go"])


@given(st.lists(EVENTS, min_size=5, max_size=40))
@settings(max_examples=150)
def test_while_stopped_nothing_makes_a_motion_and_only_a_release_ends_it(events: list[str]):
    work, stopped = stack(), False
    for event in events:
        before = work
        allowed = event != "not allowed"
        if event == "release":
            work, stopped = released(work), False
            continue
        if event == "stop":
            work, stopped = halted(interrupted(work, None), "a hand on the stop"), True
        elif event == "interrupt":
            work = interrupted(work, None)
        elif event == "assist":
            work = assisted_again(work, work.plan, frozenset({"s1", "s2", "s3"}))
        work, motion = next_motion(work, allowed)
        if stopped:
            assert motion is None and work.stopped
            assert work.carried == before.carried
        elif motion is not None and event == "fail":
            work, stopped = motion_ended(work, Ended(False, message="protective stop")), True
        elif motion is not None and event == "slip":
            work = motion_ended(work, Ended(True, holding=False, reached=None))
        elif motion is not None:
            work = motion_ended(work, obeys(motion, work))
