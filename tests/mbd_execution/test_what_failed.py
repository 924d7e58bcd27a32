"""What fell over and what is wrong in the hand is put right or asked about; every failure has a limit."""

from __future__ import annotations

from dataclasses import replace

import pytest
from mbd_execution.execution import assisted_again, begin, progress
from mbd_execution.goals import Grip, MoveTo
from mbd_execution.plan import plan
from mbd_execution.synthetic import PretendTable, blocks, demonstration, play
from mbd_model.execution_progress import Failure, Purpose, Verdict
from mbd_model.objects import Role

from tests.mbd_execution.pretend_stack import (
    HAND,
    MAPPING,
    SMALL,
    STACK,
    TARGET,
    Once,
    begun,
    colored,
    stands_on,
    work_task,
)


def test_what_lies_on_its_side_is_asked_about_before_it_is_touched():
    work, table = begun()
    thing = replace(table.objects["t1"], size=(0.05, 0.07, 0.05))
    table.objects["t1"] = replace(thing, centroid=(*thing.centroid[:2], 0.025))
    task = work_task()
    tall = {**TARGET, "1": (0.05, 0.05, 0.12)}
    work = begin(plan(task, colored(blocks(Role.TARGET, "t", tall)), MAPPING), HAND, looks=True)
    table.objects["t1"] = replace(table.objects["t1"], size=(0.05, 0.12, 0.05))
    work, motions = play(work, table)
    assert progress(work).failure is Failure.FALLEN_OVER and not any(isinstance(m, MoveTo) for m in motions)


def test_what_fell_over_early_is_asked_about_when_it_is_needed_and_is_as_tall_as_before_once_it_stands():
    """A cup that lay in two looks was taken for one that stands, and set down lying (seen in a trial)."""
    tall = {**TARGET, "3": (0.05, 0.05, 0.12)}
    work = begin(plan(work_task(), colored(blocks(Role.TARGET, "t", tall)), MAPPING), HAND, looks=True)
    table = PretendTable(work.table.objects)
    stood = table.objects["t3"]
    lies = replace(stood, size=(0.05, 0.12, 0.05), centroid=(*stood.centroid[:2], 0.025))
    table.before_look = Once(0, lambda t: t.objects.update(t3=lies))
    work, _ = play(work, table)
    now = progress(work)
    assert (now.failure, now.step_index) == (Failure.FALLEN_OVER, 2), now.text
    assert stands_on(table, "t1", "t2") and table.objects["t3"] == lies
    table.objects["t3"] = stood
    work, _ = play(assisted_again(work, work.plan, frozenset(), Verdict.YES), table)
    assert work.finished and stands_on(table, "t3", "t1")
    assert work.table["t3"].size == stood.size


def test_the_wrong_object_in_the_hand_is_seen_put_back_and_the_right_one_taken():
    """Two blocks side by side: the fingers close on the neighbour."""
    work, table = begun()
    t1, t3 = table.objects["t1"], table.objects["t3"]
    table.objects["t3"] = replace(t3, centroid=(t1.centroid[0] + 0.08, t1.centroid[1], t3.centroid[2]))
    confused = []

    def clumsy(motion, now):
        if motion == Grip(close=True) and now.course.purpose is Purpose.PICK and not confused:
            confused.append(1)
            table.grab("t3")
        return table(motion, now)

    work, _ = play(work, clumsy)
    assert confused and work.finished, progress(work).text
    assert stands_on(table, "t1", "t2") and stands_on(table, "t3", "t1")


def test_two_that_are_exchanged_before_the_hand_closes_are_told_apart_and_the_right_one_is_taken():
    """As tall as each other and of other colors: the hand, which looked before, takes the one that stands there now."""
    task = demonstration(blocks(Role.SOURCE, "s", SMALL), STACK)
    target = colored(
        blocks(Role.TARGET, "t", {"1": (0.05, 0.05, 0.07), "2": (0.09, 0.09, 0.05), "3": (0.04, 0.04, 0.07)})
    )
    work = begin(plan(task, target, MAPPING), HAND, looks=True)
    table = PretendTable(work.table.objects)
    exchanged = []

    def late(motion, now):
        if motion == Grip(close=True) and now.course.purpose is Purpose.PICK and not exchanged:
            t1, t3 = table.objects["t1"], table.objects["t3"]
            table.objects["t1"], table.objects["t3"] = (
                replace(t1, centroid=t3.centroid),
                replace(t3, centroid=t1.centroid),
            )
            exchanged.append(1)
        return table(motion, now)

    work, _ = play(work, late)
    assert exchanged and work.finished, progress(work).text
    assert stands_on(table, "t1", "t2") and stands_on(table, "t3", "t1")


@pytest.mark.parametrize("failure", [f for f in Failure if f is not Failure.NONE])
def test_every_failure_has_a_recovery_a_limit_and_a_request(failure: Failure):
    from mbd_execution.work.failures import HANDLING, trouble

    handling = HANDLING[failure]
    assert handling.limit >= 1
    question = trouble(failure, 0, "something happened", "t1")
    assert question.why.count(".") == 0 and "{" not in question.why
