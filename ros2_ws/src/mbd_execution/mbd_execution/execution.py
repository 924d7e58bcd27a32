"""The work under way, step by step: what is done, what is in the hand, which motions come next.

``next_motion`` gives what to do now, ``motion_ended`` takes how it went; between the two nothing is remembered anywhere
else, so the same code drives a real arm, the simulated cell over actions, and a test.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mbd_demonstration.trajectory import ToolPose
from mbd_model.execution_progress import Failure, Progress, Purpose, Status, Verdict

from mbd_execution.boxes import top
from mbd_execution.goals import Ended, Grip, Look, MoveTo, ToolGoal
from mbd_execution.hand import HandConfig
from mbd_execution.placing import Held
from mbd_execution.plan import Plan, Transfer
from mbd_execution.work.after_look import looked_at
from mbd_execution.work.failing import failed
from mbd_execution.work.state import STOPPING, Carried, Course, Done, Work, halted, same, with_status

__all__ = ["Work", "assisted_again", "begin", "halted", "interrupted", "motion_ended", "progress", "released"]


def begin(plan: Plan, hand: HandConfig, *, looks: bool = False) -> Work:
    """Work on a table as it was seen.

    Args:
        plan: what to do.
        hand: the hand's measures.
        looks: the table is looked at again before every step, which the arm's driver must be able to have done.
    """
    return Work(plan, plan.table, hand, statuses=(Status.PLANNED,) * plan.num_steps, looks=looks, parked=True)


def assisted_again(
    work: Work, plan: Plan, assisted: frozenset[str], verdict: Verdict = Verdict.NONE
) -> Work:  # fmt: skip
    """The work with a new plan for the same table.

    A transfer that failed is tried afresh when somebody answered for the object of the failed step, or said that it is
    put right; else it is given up. One that was done is then left as it stands.

    Args:
        work: so far.
        plan: of the new mapping.
        assisted: source objects that assists are about.
        verdict: what was answered to the question, if it takes yes or no.
    """
    if work.failure is None:
        return replace(work, plan=plan, attempts=0)
    question = work.failure
    asked = next(t for t in work.plan.transfers if question.step in (t.shown.pick, t.shown.place))
    name = asked.held if question.done else _object_of(asked, question.step)
    work = replace(work, plan=plan, failure=None, attempts=0, tries=tuple(t for t in work.tries if t[0] != name))
    if question.failure is Failure.WHICH_ONE and verdict is not Verdict.NONE:
        if verdict is Verdict.NO and question.otherwise is not None:
            return replace(work, table=question.otherwise)
        return replace(work, accepted=work.accepted | {name})
    replanned = next((t for t in plan.transfers if t.shown.pick == asked.shown.pick), None)
    other = replanned is not None and not same(asked, replanned)
    if question.done and verdict is Verdict.YES and not other:
        work = _put_right(work, asked)
        for done in work.done:
            work = _put_right(work, done.transfer) if done.transfer.held in question.also else work
        return work
    if other or verdict is Verdict.YES or _source_of(asked, question.step) in assisted:
        steps = () if question.done else (asked.shown.pick, asked.shown.place)
        return replace(work, looked=False, statuses=with_status(work.statuses, Status.PLANNED, *steps))
    if question.failure is Failure.NOT_SEEN:
        return replace(work, looked=True)
    if question.done:
        return replace(work, accepted=work.accepted | {name, *question.also})
    left_out = work.left_out | {asked.shown.pick}
    statuses = with_status(work.statuses, Status.LEFT_OUT, asked.shown.pick, asked.shown.place)
    return replace(work, left_out=left_out, statuses=statuses)


def motion_ended(work: Work, ended: Ended) -> Work:
    """The work after the first motion of its course ended by itself."""
    course = work.course
    if course is None:
        return work
    if ended.stops:
        return halted(interrupted(work, ended.reached), ended.message or f"the arm failed: {ended.error.name}")
    motion, rest = course.motions[0], course.motions[1:]
    parked = work.parked and not isinstance(motion, MoveTo)
    tool = ended.reached or work.tool
    work = replace(work, tool=tool, parked=parked, course=replace(course, motions=rest) if rest else None)
    if not ended.success:
        return failed(work, course, Failure.NO_WAY, ended.message)
    if isinstance(motion, Look):
        if ended.seen is None:
            return failed(work, course, Failure.NOT_SEEN, ended.message or "perception answered without a scene")
        return looked_at(replace(work, course=None, attempts=0), ended.seen)
    if isinstance(motion, Grip):
        if motion.close and work.carried is not None:
            return work if ended.holding else failed(work, course, Failure.SLIPPED, "nothing is in my hand any more")
        if motion.close:
            if not ended.holding:
                return failed(work, course, Failure.NOT_GRASPED, "the hand closed on nothing")
            return _grasped(work, course)
        if course.purpose in (Purpose.PLACE, Purpose.RETURN):
            return _released(work, course)
    return work


def interrupted(work: Work, reached: ToolGoal | None) -> Work:
    """The work after its motion was stopped from outside: what comes next is planned from where the tool is."""
    return replace(work, course=None, tool=reached or work.tool)


def released(work: Work) -> Work:
    """The work after a person let the robot go on; the motion that was cut short is planned afresh."""
    return replace(work, stopped="")


def progress(work: Work) -> Progress:
    """What to report of it."""
    if work.stopped:
        return Progress(-1, Status.STOPPED, f"stopped: {work.stopped}; it goes on when you resume", work.statuses)
    if work.failure and (work.course is None or work.course.purpose not in STOPPING):
        step, why, failure = work.failure.step, work.failure.why, work.failure.failure
        return Progress(step, Status.FAILED, f"step {step + 1} failed: {why}", work.statuses, failure=failure)
    if work.finished:
        missing = [i + 1 for i, s in enumerate(work.statuses) if s is Status.LEFT_OUT]
        but = f", but for step {' and '.join(map(str, missing))}" if missing else ""
        return Progress(-1, Status.FINISHED, f"the task is done{but}", work.statuses)
    course = work.course
    if course is None:
        return Progress(-1, Status.PLANNED, "ready to go on", work.statuses)
    shown, held = course.transfer.shown, course.transfer.held
    step, receiver = shown.pick, ""
    text = f"{course.purpose.words} {held}"
    if course.purpose is Purpose.PICK:
        text = f"step {step + 1}: {text} for {shown.picked.object_id}"
    elif course.purpose is Purpose.PLACE:
        step, receiver = shown.place, course.transfer.receiver or ""
        text = f"step {step + 1}: set {held} down {f'onto {receiver}' if receiver else 'on the table'}"
    elif course.purpose is Purpose.LOOK and work.next_transfer is None:
        step, text = -1, "look whether everything stands where it should"
    if work.noticed:
        text = f"{text} ({work.noticed})"
    return Progress(step, Status.UNDER_WAY, text, work.statuses, course.purpose, held, receiver)


def _object_of(transfer: Transfer, step: int) -> str:
    """The target object that a step is about."""
    if step == transfer.shown.place and transfer.receiver:
        return transfer.receiver
    return transfer.held


def _put_right(work: Work, transfer: Transfer) -> Work:
    """The work after somebody put an object where it belongs: it is believed there, and the next look shows where."""
    table, held, receiver = work.table, transfer.held, transfer.receiver
    if receiver and (held, receiver) not in table.rests_on:
        x, y, _ = table[receiver].centroid
        there = replace(table[held], centroid=(x, y, top(table[receiver]) + table[held].size[2] / 2))
        table = replace(table, objects=tuple(there if o.object_id == held else o for o in table.objects))
        table = table.put_onto(held, receiver)
    return replace(work, table=table, looked=False, gone=work.gone - {held}, accepted=work.accepted | {held})


def _source_of(transfer: Transfer, step: int) -> str:
    shown = transfer.shown
    if step == shown.place and shown.receiver is not None:
        return shown.receiver.object_id
    return shown.picked.object_id


def _grasped(work: Work, course: Course) -> Work:
    box = work.table[course.transfer.held]
    origin = box
    if course.purpose is Purpose.FETCH:
        origin = next(d.origin for d in work.done if same(d.transfer, course.transfer))
    statuses = work.statuses
    if course.purpose is Purpose.PICK:
        statuses = with_status(statuses, Status.DONE, course.transfer.shown.pick)
    carried = Carried(Held(box, course.goal), course.transfer, origin)
    done = work.done[:-1] if course.purpose is Purpose.FETCH else work.done
    after = replace(work, carried=carried, done=done, attempts=0, statuses=statuses)
    return replace(after, looked=False, parked=False, noticed="")


def _released(work: Work, course: Course) -> Work:
    carried, shown = work.carried, course.transfer.shown
    if carried is None:
        return work
    settled = course.goal.at_height(course.goal.z - work.hand.release_gap)
    table = work.table.carried(course.transfer.held, _pose(carried.held.grasp), _pose(settled))
    done, statuses = work.done, work.statuses
    if course.purpose is Purpose.PLACE:
        if course.transfer.receiver:
            table = table.put_onto(course.transfer.held, course.transfer.receiver)
        done = (*done, Done(course.transfer, carried.origin))
        statuses = with_status(statuses, Status.DONE, shown.place)
    else:
        statuses = with_status(statuses, Status.PLANNED, shown.pick, shown.place)
    if work.failure:
        statuses = with_status(statuses, Status.FAILED, work.failure.step)
    after = replace(work, table=table, carried=None, done=done, attempts=0, statuses=statuses)
    return replace(after, looked=False, parked=False, noticed="")


def _pose(goal: ToolGoal) -> ToolPose:
    return ToolPose(np.array((goal.x, goal.y, goal.z)), np.array(goal.quaternion))
