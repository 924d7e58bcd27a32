"""What to do next: go on with the plan, put back what it wants otherwise, or stop."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.execution_progress import Purpose, Status
from mbd_model.objects import SceneObject

from mbd_execution import routes
from mbd_execution.boxes import bottom
from mbd_execution.execution import STOPPING, Course, Work, same, with_status
from mbd_execution.goals import Grip, Motion, turn_between
from mbd_execution.grasping import grasp
from mbd_execution.placing import release
from mbd_execution.plan import Transfer


def next_motion(work: Work, allowed: bool) -> tuple[Work, Motion | None]:
    """The motion to make now.

    Args:
        work: so far; the last motion has ended.
        allowed: the robot may go on alone. When it may not, what is in the hand goes back where it came from.

    Returns:
        The work with that motion under way, and the motion; None when there is nothing to do, or not now, or since
        everything stands.
    """
    if work.stopped:
        return work, None
    if work.course is None:
        work = _begin_course(work, allowed)
    return work, work.course.motions[0] if work.course else None


def may_be_stopped(work: Work) -> bool:
    """Whether the motion under way may be cut short: a hand that is closing may not, nor is putting back stopped."""
    course = work.course
    return course is not None and course.purpose not in STOPPING and not isinstance(course.motions[0], Grip)


def _begin_course(work: Work, allowed: bool) -> Work:
    carried, following = work.carried, work.next_transfer
    if carried is not None:
        fits = following is not None and same(carried.transfer, following) and work.undo is None
        if not allowed or work.failure or not fits:
            return _return(work)
        return _place(work, carried.transfer)
    if work.failure or not allowed:
        return work
    if work.undo is not None:
        return _pick(work, work.undo.transfer, Purpose.FETCH)
    if following is None:
        return work
    if following.problem:
        step = following.problem_step
        statuses = with_status(work.statuses, Status.FAILED, step)
        return replace(work, failure=(step, following.problem), statuses=statuses)
    return _pick(work, following, Purpose.PICK)


def _others(work: Work, *but: str | None) -> tuple[SceneObject, ...]:
    return tuple(o for o in work.table.objects if o.object_id not in but)


def _pick(work: Work, transfer: Transfer, purpose: Purpose) -> Work:
    others = _others(work, transfer.held)
    goal = grasp(work.table[transfer.held], transfer.shown, others, work.hand, work.attempts)
    motions = routes.pick(goal, work.tool, work.table.objects, work.hand)
    statuses = work.statuses
    if purpose is Purpose.PICK:
        statuses = with_status(statuses, Status.UNDER_WAY, transfer.shown.pick)
    return replace(work, course=Course(purpose, transfer, goal, motions), statuses=statuses)


def _place(work: Work, transfer: Transfer) -> Work:
    if work.carried is None:
        return work
    held = work.carried.held
    others = _others(work, transfer.held, transfer.receiver)
    receiver = work.table[transfer.receiver] if transfer.receiver else None
    goal = release(held, transfer.shown, receiver, others, work.hand)
    around = _others(work, transfer.held)
    motions = routes.place(goal, work.tool, held.below_tool, around, work.hand)
    statuses = with_status(work.statuses, Status.UNDER_WAY, transfer.shown.place)
    return replace(work, course=Course(Purpose.PLACE, transfer, goal, motions), statuses=statuses)


def _return(work: Work) -> Work:
    """Put what is in the hand back where it came from."""
    if work.carried is None:
        return work
    held, origin = work.carried.held, work.carried.origin
    yaw = held.grasp.yaw + turn_between(held.box.yaw, origin.yaw)
    base = bottom(origin) + work.hand.release_gap
    goal = held.tool_over(origin.centroid[0], origin.centroid[1], base, yaw)
    motions = routes.place(goal, work.tool, held.below_tool, _others(work, held.box.object_id), work.hand)
    return replace(work, course=Course(Purpose.RETURN, work.carried.transfer, goal, motions))
