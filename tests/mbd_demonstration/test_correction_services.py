"""What the demonstration node is asked to correct, the task keeps."""

from __future__ import annotations

import dataclasses

import numpy as np
from demonstration_session import Session, steps_of
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate
from mbd_model.objects import Role
from mbd_model.objects import Scene as SourceScene
from mbd_model.ros.conversions import time_from_msg, time_to_msg
from mbd_msgs.srv import ReviseTask


def test_the_last_step_can_be_dropped(session: Session, shown: Demonstration):
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    session.ask("stop")
    answer = session.ask("delete_last")
    assert answer.success and answer.message == "deleted step 4, PLACE s1; 3 steps left", answer.message
    session.until(lambda: len(session.tasks) > 1)
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps[:-1]]


def test_the_last_step_can_be_shown_again(session: Session, shown: Demonstration):
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    session.ask("stop")
    assert session.ask("rerecord_last").success
    now = SourceScene(Role.SOURCE, shown.after)
    again = demonstrate(now, (Move("s3", onto="s2"),), Sensing(rate=10.0), np.random.default_rng(4), begin=200.0)
    session.play(dataclasses.replace(again, scene=shown.scene))
    assert session.ask("stop").success
    session.until(lambda: len(session.tasks) > 2)
    assert steps_of(session.tasks[-1])[:-1] == [(int(k), i) for k, i in shown.steps[:-1]]


CHANGE = ReviseTask.Request


def revised(session: Session, **change: object) -> list[tuple[int, str]]:
    """The steps of the task after a correction, which must be said in the task as in the answer."""
    before = len(session.tasks)
    answer = session.revise(**change)
    assert answer.success, answer.message
    session.until(lambda: len(session.tasks) > before)
    task = session.tasks[-1]
    assert "by the teacher" in task.problems[-1] and task.problems[-1] in answer.message
    assert [s.index for s in task.steps] == list(range(len(task.steps)))
    assert len(task.doubts) == len(task.steps)
    return steps_of(task)


def test_each_step_is_corrected_by_service_and_the_task_keeps_it(session: Session, shown: Demonstration):
    """One after the other, of s1 onto s2 and s3 onto s1, as a teacher would; each is about the task as it is then."""
    session.show(shown)
    task = session.tasks[-1]
    steps = steps_of(task)
    on_the_way = time_to_msg((time_from_msg(task.steps[2].end) + time_from_msg(task.steps[3].end)) / 2)
    split = revised(session, change=CHANGE.SPLIT, step=3, at=on_the_way)
    assert split == [*steps[:3], (2, "s3"), (1, "s3"), steps[3]]
    assert revised(session, change=CHANGE.JOIN, step=3) == steps
    assert revised(session, change=CHANGE.MOVE, step=2, to=0) == [*steps[2:], *steps[:2]]
    assert revised(session, change=CHANGE.MOVE, step=0, to=4) == steps
    assert revised(session, change=CHANGE.CHANGE_OBJECT, step=3, object="s2") == [*steps[:3], (2, "s2")]
    assert revised(session, change=CHANGE.DELETE, step=0) == [steps[2], (2, "s2")]


def test_a_correction_that_cannot_be_is_refused_with_the_reason_and_changes_nothing(
    session: Session, shown: Demonstration
):
    session.show(shown)
    published = len(session.tasks)
    for change, reason in (
        ({"change": CHANGE.DELETE, "step": 9}, "there is no step 10"),
        ({"change": CHANGE.CHANGE_OBJECT, "step": 0, "object": "s9"}, "has no object 's9'"),
        ({"change": CHANGE.CHANGE_OBJECT, "step": 0, "object": "s1"}, "already, without a doubt"),
        ({"change": CHANGE.SPLIT, "step": 1, "at": time_to_msg(5.0)}, "no longer known"),
        ({"change": CHANGE.JOIN, "step": 1}, "is not put down and taken again"),
        ({"change": 99, "step": 0}, "change 99 is unknown"),
    ):
        answer = session.revise(**change)
        assert not answer.success and reason in answer.message, answer.message
    assert len(session.tasks) == published


def test_steps_are_recorded_again_from_one_on_and_those_before_stay(session: Session, shown: Demonstration):
    session.show(shown)
    session.tool_is_there()
    answer = session.revise(change=CHANGE.RERECORD, step=2)
    assert answer.success, answer.message
    now = SourceScene(Role.SOURCE, shown.after)
    again = demonstrate(now, (Move("s3", onto="s2"),), Sensing(rate=10.0), np.random.default_rng(4), begin=200.0)
    session.play(dataclasses.replace(again, scene=shown.scene))
    before = len(session.tasks)
    assert session.ask("stop").success
    session.until(lambda: len(session.tasks) > before)
    kept = [(int(k), i) for k, i in shown.steps[:2]]
    assert steps_of(session.tasks[-1])[:3] == [*kept, (1, "s3")]
    assert any("recorded again by the teacher" in p for p in session.tasks[-1].problems)
