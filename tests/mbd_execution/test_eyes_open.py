"""Work that looks at the table before every step: what is disturbed is followed, put right, or asked about."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_execution.choosing import next_motion
from mbd_execution.execution import assisted_again, begin, motion_ended, progress
from mbd_execution.goals import Grip, Look, MoveTo
from mbd_execution.plan import plan
from mbd_execution.synthetic import PretendTable, blocks, demonstration, play
from mbd_model.execution_progress import Failure, Purpose, Status, Verdict
from mbd_model.objects import Role

from tests.mbd_execution.pretend_stack import (
    HAND,
    SMALL,
    STACK,
    STOOD,
    TARGET,
    Once,
    begun,
    colored,
    moved,
    stands_on,
    work_task,
)


def test_it_looks_before_every_step_and_once_more_at_the_end_with_the_arm_aside():
    work, table = begun()
    purposes, tool = [], None
    while True:
        work, motion = next_motion(work, allowed=True)
        if motion is None:
            break
        if isinstance(motion, Look):
            assert tool is None or (tool.x, tool.y) == HAND.look_from[:2]
        tool = motion.goal if isinstance(motion, MoveTo) else tool
        if not purposes or purposes[-1] is not work.course.purpose:
            purposes.append(work.course.purpose)
        work = motion_ended(work, table(motion, work))
    assert work.finished
    assert purposes == [Purpose.LOOK, Purpose.PICK, Purpose.LOOK, Purpose.PLACE] * 2 + [Purpose.LOOK]
    assert stands_on(table, "t1", "t2") and stands_on(table, "t3", "t1")


@given(
    name=st.sampled_from(("t1", "t2", "t3")),
    number=st.integers(0, 3),
    angle=st.floats(0.0, 2 * math.pi),
    far=st.floats(0.0, 0.05),
)
@settings(max_examples=60, deadline=None)
def test_whatever_is_pushed_whenever_the_task_ends_right_and_nobody_is_asked(name, number, angle, far):
    work, table = begun()

    def push(now: PretendTable) -> None:
        dx, dy = far * math.cos(angle), far * math.sin(angle)
        supported = [n for n in now.objects if n != name and stands_on(now, n, name)]
        on_another = any(stands_on(now, name, n) for n in now.objects if n != name)
        if name != now.held and not on_another:
            for thing in (name, *supported):
                now.objects[thing] = moved(now.objects[thing], dx, dy)

    table.before_look = Once(number, push)
    work, _ = play(work, table)
    assert progress(work).status is Status.FINISHED, progress(work).text
    assert stands_on(table, "t1", "t2") and stands_on(table, "t3", "t1")


def test_what_was_taken_away_is_asked_about_and_nothing_moves_until_it_is_back():
    work, table = begun()
    taken = table.objects.pop("t1")
    work, motions = play(work, table)
    now = progress(work)
    assert (now.status, now.failure, now.step_index) == (Status.FAILED, Failure.NOT_THERE, 0)
    assert "t1" in now.text and not any(isinstance(m, MoveTo) for m in motions)
    table.objects["t1"] = moved(taken, 0.1, 0.12)
    work, _ = play(assisted_again(work, work.plan, frozenset(), Verdict.YES), table)
    assert work.finished and stands_on(table, "t1", "t2") and stands_on(table, "t3", "t1")


def test_what_was_taken_away_and_skipped_is_left_out():
    work, table = begun()
    del table.objects["t3"]
    work, _ = play(work, table)
    assert progress(work).failure is Failure.NOT_THERE and progress(work).step_index == 2
    work, _ = play(assisted_again(work, work.plan, frozenset()), table)
    assert work.finished and stands_on(table, "t1", "t2")
    assert work.statuses == (Status.DONE, Status.DONE, Status.LEFT_OUT, Status.LEFT_OUT)


def test_an_object_that_is_answered_in_place_of_a_missing_one_is_used():
    work, table = begun()
    del table.objects["t1"]
    work, _ = play(work, table)
    again = plan(work_task(), colored(blocks(Role.TARGET, "t", TARGET)), {"s1": "t3", "s2": "t2"})
    work, _ = play(assisted_again(work, again, frozenset({"s1"}), Verdict.YES), table)
    assert stands_on(table, "t3", "t2")


def test_a_stranger_on_the_table_is_noticed_and_left_alone():
    work, table = begun()
    stranger = replace(table.objects["t2"], object_id="stranger", centroid=(0.3, 0.3, 0.03), size=(0.1, 0.06, 0.06))
    texts = []

    def watch(motion, now):
        texts.append(progress(now).text)
        return table(motion, now)

    table.before_look = Once(1, lambda t: t.objects.update(stranger=replace(stranger, hue=60.0)))
    work, _ = play(work, watch)
    assert work.finished and table.objects["stranger"].centroid == stranger.centroid
    assert any("is new" in text for text in texts)


@pytest.mark.parametrize(("verdict", "yes"), [(Verdict.YES, True), (Verdict.NO, False)])
def test_a_stranger_that_looks_like_one_still_needed_is_asked_about_and_the_answer_is_obeyed(verdict, yes):
    work, table = begun()
    stranger = replace(table.objects["t3"], object_id="stranger", centroid=(0.3, 0.3, 0.02))
    table.before_look = Once(1, lambda t: t.objects.update(stranger=stranger))
    work, _ = play(work, table)
    now = progress(work)
    assert (now.status, now.failure, now.step_index) == (Status.FAILED, Failure.WHICH_ONE, 2), now.text
    assert "t3" in now.text and "(0.30, 0.30)" in now.text
    table.before_look = lambda _: None
    work, _ = play(assisted_again(work, work.plan, frozenset(), verdict), table)
    assert work.finished and stands_on(table, "t3" if yes else "stranger", "t1")


def test_two_twins_that_change_places_are_asked_about_and_either_answer_is_obeyed():
    for verdict, yes in ((Verdict.YES, True), (Verdict.NO, False)):
        task = demonstration(blocks(Role.SOURCE, "s", SMALL), STACK[:1])
        sizes = {"1": (0.05, 0.05, 0.07), "2": (0.09, 0.09, 0.05), "3": (0.052, 0.05, 0.075)}
        target = colored(blocks(Role.TARGET, "t", sizes))
        hues = {"t1": 10.0, "t2": 130.0, "t3": 24.0}
        target = replace(target, objects=tuple(replace(o, hue=hues[o.object_id]) for o in target.objects))
        work = begin(plan(task, target, {"s1": "t1", "s2": "t2"}), HAND, looks=True)
        table = PretendTable(work.table.objects)
        one, other = table.objects["t1"], table.objects["t3"]
        table.objects["t1"] = replace(one, centroid=(*other.centroid[:2], one.centroid[2]))
        table.objects["t3"] = replace(other, centroid=(*one.centroid[:2], other.centroid[2]))
        work, motions = play(work, table)
        now = progress(work)
        assert (now.status, now.failure) == (Status.FAILED, Failure.WHICH_ONE), now.text
        assert not any(isinstance(m, MoveTo) for m in motions)
        taken = work.table["t1"].centroid[:2]
        work, _ = play(assisted_again(work, work.plan, frozenset(), verdict), table)
        assert work.finished
        placed = next(n for n in ("t1", "t3") if stands_on(table, n, "t2"))
        stood = {"t1": other.centroid[:2], "t3": one.centroid[:2]}  # as they were laid here
        said = min(stood, key=lambda n: math.dist(stood[n], taken))
        assert (placed == said) is yes


def test_two_of_one_shape_and_clearly_other_colors_that_change_places_are_told_apart_without_a_question():
    sizes = {"1": (0.05, 0.05, 0.07), "2": (0.09, 0.09, 0.05), "3": (0.05, 0.05, 0.07)}
    target = colored(blocks(Role.TARGET, "t", sizes))
    task = demonstration(blocks(Role.SOURCE, "s", SMALL), STACK[:1])
    work = begin(plan(task, target, {"s1": "t1", "s2": "t2"}), HAND, looks=True)
    table = PretendTable(work.table.objects)
    one, other = table.objects["t1"], table.objects["t3"]
    table.objects.update(t1=replace(one, centroid=other.centroid), t3=replace(other, centroid=one.centroid))
    work, _ = play(work, table)
    assert work.finished and stands_on(table, "t1", "t2")


@pytest.mark.parametrize("check", [1, 2, 3])
def test_what_slips_out_on_the_way_is_picked_up_again_where_it_lies(check: int):
    """At the look, above the place, or on the way down to it: the fingers tell, before the hand opens."""
    work, table = begun()
    checked = []
    lost = []

    def drop(now: PretendTable) -> None:
        pass

    def slippery(motion, now):
        if motion == Grip(close=True) and now.carried is not None:
            checked.append(now.course.purpose)
        if len(checked) == check and not lost:
            lost.append(table.held)
            name, table.held = table.held, ""
            table.objects[name] = moved(table.objects[name], 0.06, 0.05)
        return table(motion, now)

    table.before_look = drop
    work, _ = play(work, slippery)
    assert lost == ["t1"] and work.finished
    assert stands_on(table, "t1", "t2") and stands_on(table, "t3", "t1")


def test_what_falls_off_after_it_was_placed_is_placed_again_once_and_then_asked_about():
    work, table = begun()

    def fall(now: PretendTable) -> None:
        if now.held != "t1" and stands_on(now, "t1", "t2"):
            falls.append(1)
            thing = now.objects["t1"]
            now.objects["t1"] = replace(thing, centroid=(0.55, 0.2, thing.size[2] / 2))

    falls: list[int] = []
    table.before_look = fall
    work, _ = play(work, table)
    now = progress(work)
    assert len(falls) == 2
    assert (now.status, now.failure, now.step_index) == (Status.FAILED, Failure.NOT_IN_PLACE, 1), now.text
    accepted = assisted_again(work, work.plan, frozenset())
    table.before_look = lambda _: None
    left, _ = play(accepted, table)
    assert left.finished
    # Somebody puts it where it belongs, and says so: that is where the next one goes.
    base, thing = table.objects["t2"], table.objects["t1"]
    height = base.centroid[2] + base.size[2] / 2 + thing.size[2] / 2
    table.objects["t1"] = replace(thing, centroid=(*base.centroid[:2], height))
    third = table.objects["t3"]
    table.objects["t3"] = replace(third, centroid=(*STOOD, third.size[2] / 2))
    work, _ = play(assisted_again(work, work.plan, frozenset(), Verdict.YES), table)
    assert work.finished and stands_on(table, "t1", "t2") and stands_on(table, "t3", "t1")


@pytest.mark.parametrize("verdict", [Verdict.YES, Verdict.NONE])
def test_a_pile_that_has_fallen_is_asked_about_once_and_put_right_or_left_as_a_whole(verdict: Verdict):
    work, table = begun()
    work, _ = play(work, table)
    assert work.finished and stands_on(table, "t3", "t1")
    stood = dict(table.objects)
    for k, name in enumerate(("t1", "t3")):
        thing = table.objects[name]
        table.objects[name] = replace(thing, centroid=(0.4 + 0.15 * k, 0.25, thing.size[2] / 2))
    work, _ = play(replace(work, looked=False), table)
    assert work.failure is not None
    assert (work.failure.failure, work.failure.also) == (Failure.NOT_IN_PLACE, ("t3",))
    assert "t3 likewise" in work.failure.why and "put t1 and t3 where they belong" in work.failure.why
    if verdict is Verdict.YES:
        table.objects |= stood
    work, motions = play(assisted_again(work, work.plan, frozenset(), verdict), table)
    assert work.finished, work.failure
    assert not any(isinstance(m, Grip) for m in motions)
