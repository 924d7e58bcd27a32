"""What to do next: go on with the plan, put back what it wants otherwise, or stop."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.execution_progress import Failure, Purpose, Status

from mbd_execution import routes
from mbd_execution.boxes import bottom
from mbd_execution.detours import Load, NoWayError
from mbd_execution.goals import Grip, Look, Motion, ToolGoal, turn_between
from mbd_execution.grasps.candidates import grasp_candidates
from mbd_execution.placing import release
from mbd_execution.plan import Transfer
from mbd_execution.work.failing import failed
from mbd_execution.work.failures import trouble
from mbd_execution.work.state import STOPPING, Course, Work, halted, same, with_status

MOST_ATTEMPTS = 8  # beginnings of a course in one go, each with another grasp where there is no way


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
    for _ in range(MOST_ATTEMPTS):
        if work.course is not None:
            break
        before, work = work, _begin_course(work, allowed)
        if work == before:
            break
    return work, work.course.motions[0] if work.course else None


def may_be_stopped(work: Work) -> bool:
    """Whether the motion under way may be cut short: a hand that is closing may not, nor is putting back stopped."""
    course = work.course
    return course is not None and course.purpose not in STOPPING and not isinstance(course.motions[0], Grip)


def _begin_course(work: Work, allowed: bool) -> Work:
    """The work with its next course; one to which there is no free way has failed before it began."""
    carried, following = work.carried, work.next_transfer
    try:
        return _course_begun(work, allowed)
    except NoWayError as error:
        transfer = carried.transfer if carried else following
        if transfer is None:
            return halted(work, str(error))
        if carried is not None and (work.failure or not allowed or work.undo is not None):
            return halted(work, f"I cannot put {carried.held.box.object_id} back: {error}")
        purpose = Purpose.LOOK if work.must_look else Purpose.PLACE if carried else Purpose.PICK
        course = Course(purpose, transfer, work.tool or ToolGoal(*work.hand.look_from), ())
        after = failed(work, course, error.failure, str(error))
        # Nothing was touched, so there is nothing to let go of.
        return replace(after, course=None, carried=carried)


def _course_begun(work: Work, allowed: bool) -> Work:
    carried, following = work.carried, work.next_transfer
    if carried is not None:
        fits = following is not None and same(carried.transfer, following) and work.undo is None
        if not allowed or work.failure or not fits:
            return _return(work)
        return _look(work, carried.transfer) if work.must_look else _place(work, carried.transfer)
    if work.failure or not allowed:
        return work
    if work.must_look:
        after = work.undo.transfer if work.undo else following or (work.done[-1].transfer if work.done else None)
        return work if after is None else _look(work, after)
    if work.undo is not None:
        return _pick(work, work.undo.transfer, Purpose.FETCH)
    if following is None:
        return work
    if following.problem:
        step = following.problem_step
        statuses = with_status(work.statuses, Status.FAILED, step)
        question = trouble(Failure.NO_COUNTERPART, step, following.problem, following.held)
        return replace(work, failure=question, statuses=statuses)
    return _pick(work, following, Purpose.PICK)


def _look(work: Work, transfer: Transfer) -> Work:
    """Look at the table with the arm, and what it holds, out of view; check by the fingers that it still holds it."""
    motions: list[Motion] = []
    # What is held stays as level as it is.
    out_of_view = ToolGoal(*work.hand.look_from, tilt=work.carried.held.grasp.tilt if work.carried else 0.0)
    if not work.parked:
        held = work.carried.held.box.object_id if work.carried else None
        motions += routes.aside(out_of_view, work.tool, _load(work), work.others(held), work.hand)
    if work.carried is not None:
        motions.append(Grip(close=True))
    course = Course(Purpose.LOOK, transfer, out_of_view, (*motions, Look()))
    return replace(work, course=course)


def _load(work: Work) -> Load:
    """What hangs from the tool."""
    if work.carried is None:
        return Load(work.hand.fingertip_drop)
    return Load(max(work.carried.held.below_tool, work.hand.fingertip_drop), work.carried.held.reach)


def _pick(work: Work, transfer: Transfer, purpose: Purpose) -> Work:
    others = work.others(transfer.held)
    ways = grasp_candidates(work.table[transfer.held], transfer.shown, others, work.hand)
    goal = ways[work.attempts % len(ways)].goal
    motions = routes.pick(goal, work.tool, work.others(), work.hand)
    statuses = work.statuses
    if purpose is Purpose.PICK:
        statuses = with_status(statuses, Status.UNDER_WAY, transfer.shown.pick)
    return replace(work, course=Course(purpose, transfer, goal, motions), statuses=statuses)


def _place(work: Work, transfer: Transfer) -> Work:
    if work.carried is None:
        return work
    held = work.carried.held
    others = work.others(transfer.held, transfer.receiver)
    receiver = work.table[transfer.receiver] if transfer.receiver else None
    goal = release(held, transfer.shown, receiver, others, work.hand)
    around = work.others(transfer.held)
    motions = routes.place(goal, work.tool, _load(work), around, work.hand)
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
    motions = routes.place(goal, work.tool, _load(work), work.others(held.box.object_id), work.hand)
    return replace(work, course=Course(Purpose.RETURN, work.carried.transfer, goal, motions))
