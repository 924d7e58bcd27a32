"""The work under way, as a value: what is done, what is in the hand, which motions come next.

``next_motion`` gives what to do now, ``motion_ended`` takes how it went; between the two nothing is remembered anywhere
else, so the same code drives a real arm, the simulated cell over actions, and a test.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose
from mbd_model.execution_progress import Progress, Purpose, Status
from mbd_model.objects import SceneObject

from mbd_execution.goals import Ended, Grip, Motion, ToolGoal
from mbd_execution.hand import HandConfig
from mbd_execution.placing import Held
from mbd_execution.plan import Plan, Transfer
from mbd_execution.routes import let_go

ATTEMPTS = 2  # of a pick or place: it is retried once, then asked about


# Begun courses of these are ended even while the robot is asked to stop: they are what stopping means.
STOPPING = frozenset({Purpose.RETURN, Purpose.LET_GO})


@dataclass(frozen=True)
class Course:
    """Motions towards one end.

    Attributes:
        purpose: what for.
        transfer: which it is part of.
        goal: where the hand closes or opens.
        motions: those still to come, the one under way first.
    """

    purpose: Purpose
    transfer: Transfer
    goal: ToolGoal
    motions: tuple[Motion, ...]


@dataclass(frozen=True)
class Carried:
    """What is in the hand, for which transfer, and where it came from."""

    held: Held
    transfer: Transfer
    origin: SceneObject


@dataclass(frozen=True)
class Done:
    """A transfer that was done, and where its object came from."""

    transfer: Transfer
    origin: SceneObject


@dataclass(frozen=True)
class Work:
    """Everything about the work.

    Attributes:
        plan: what to do.
        table: where the objects are believed to be.
        hand: the hand's measures.
        done: transfers done, in order.
        carried: what is in the hand.
        course: the motions under way.
        attempts: failed ones of the present pick, place or taking back.
        failure: (step, why) once it failed for the last time.
        left_out: first steps of the transfers given up.
        statuses: of each step.
        tool: where the tool was last known to be.
        stopped: why nothing may move until a person resumes; "" when it may.
    """

    plan: Plan
    table: TrackedObjects
    hand: HandConfig
    done: tuple[Done, ...] = ()
    carried: Carried | None = None
    course: Course | None = None
    attempts: int = 0
    failure: tuple[int, str] | None = None
    left_out: frozenset[int] = frozenset()
    statuses: tuple[Status, ...] = ()
    tool: ToolGoal | None = None
    stopped: str = ""

    @property
    def wanted(self) -> tuple[Transfer, ...]:
        """The plan's transfers without those given up."""
        return tuple(t for t in self.plan.transfers if t.shown.pick not in self.left_out)

    @property
    def undo(self) -> Done | None:
        """The last transfer done, when the plan wants it otherwise now; above it nothing can stand."""
        wanted = self.wanted
        agree = 0
        while agree < min(len(self.done), len(wanted)) and same(self.done[agree].transfer, wanted[agree]):
            agree += 1
        return self.done[-1] if agree < len(self.done) else None

    @property
    def next_transfer(self) -> Transfer | None:
        """The first that is not done."""
        wanted = self.wanted
        return wanted[len(self.done)] if len(self.done) < len(wanted) else None

    @property
    def finished(self) -> bool:
        """Nothing is left to do."""
        idle = self.course is None and self.carried is None and self.failure is None
        return idle and self.undo is None and self.next_transfer is None


def same(one: Transfer, other: Transfer) -> bool:
    """Whether two transfers move the same object to the same place for the same steps."""
    return (one.shown.pick, one.held, one.receiver) == (other.shown.pick, other.held, other.receiver)


def begin(plan: Plan, hand: HandConfig) -> Work:
    """Work on a table as it was seen."""
    return Work(plan, plan.table, hand, statuses=(Status.PLANNED,) * plan.num_steps)


def assisted_again(work: Work, plan: Plan, assisted: frozenset[str]) -> Work:
    """The work with a new plan for the same table.

    A transfer that failed is tried afresh when somebody answered for the object of the failed step, else given up.

    Args:
        work: so far.
        plan: of the new mapping.
        assisted: source objects that assists are about.
    """
    left_out, statuses = work.left_out, work.statuses
    if work.failure:
        step = work.failure[0]
        failed = next(t for t in work.plan.transfers if step in (t.shown.pick, t.shown.place))
        given_up = _source_of(failed, step) not in assisted
        if given_up:
            left_out = left_out | {failed.shown.pick}
        outcome = Status.LEFT_OUT if given_up else Status.PLANNED
        statuses = with_status(statuses, outcome, failed.shown.pick, failed.shown.place)
    return replace(work, plan=plan, failure=None, attempts=0, left_out=left_out, statuses=statuses)


def motion_ended(work: Work, ended: Ended) -> Work:
    """The work after the first motion of its course ended by itself."""
    course = work.course
    if course is None:
        return work
    if ended.stops:
        return halted(interrupted(work, ended.reached), ended.message or f"the arm failed: {ended.error.name}")
    motion, rest = course.motions[0], course.motions[1:]
    work = replace(work, tool=ended.reached or work.tool, course=replace(course, motions=rest) if rest else None)
    if not ended.success:
        return _failed(work, course, ended.message)
    if isinstance(motion, Grip):
        if motion.close:
            if not ended.holding:
                return _failed(work, course, "the hand closed on nothing")
            return _grasped(work, course)
        if course.purpose in (Purpose.PLACE, Purpose.RETURN):
            return _released(work, course)
    return work


def interrupted(work: Work, reached: ToolGoal | None) -> Work:
    """The work after its motion was stopped from outside: what comes next is planned from where the tool is."""
    return replace(work, course=None, tool=reached or work.tool)


def halted(work: Work, why: str) -> Work:
    """The work after a stop: no motion comes of it before ``released``, whatever happens meanwhile."""
    return replace(work, stopped=work.stopped or why or "stopped")


def released(work: Work) -> Work:
    """The work after a person let the robot go on; the motion that was cut short is planned afresh."""
    return replace(work, stopped="")


def progress(work: Work) -> Progress:
    """What to report of it."""
    if work.stopped:
        return Progress(-1, Status.STOPPED, f"stopped: {work.stopped}; it goes on when you resume", work.statuses)
    if work.failure and (work.course is None or work.course.purpose not in STOPPING):
        step, why = work.failure
        return Progress(step, Status.FAILED, f"step {step + 1} failed: {why}", work.statuses)
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
    return Progress(step, Status.UNDER_WAY, text, work.statuses, course.purpose, held, receiver)


def with_status(statuses: tuple[Status, ...], status: Status, *steps: int) -> tuple[Status, ...]:
    """The statuses with those of some steps changed."""
    return tuple(status if i in steps else s for i, s in enumerate(statuses))


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
    return replace(work, carried=carried, done=done, attempts=0, statuses=statuses)


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
        statuses = with_status(statuses, Status.FAILED, work.failure[0])
    return replace(work, table=table, carried=None, done=done, attempts=0, statuses=statuses)


def _failed(work: Work, course: Course, why: str) -> Work:
    """One attempt of a course failed."""
    shown = course.transfer.shown
    if course.purpose is Purpose.LET_GO:
        return replace(work, course=None)
    step = shown.place if course.purpose is Purpose.PLACE else shown.pick
    attempts = work.attempts + 1
    if attempts < ATTEMPTS:
        return replace(work, course=None, attempts=attempts)
    what = f"I could not {course.purpose.words} {course.transfer.held}: {why}"
    statuses = with_status(work.statuses, Status.FAILED, step)
    done = work.done[:-1] if course.purpose is Purpose.FETCH else work.done
    work = replace(work, course=None, attempts=0, failure=(step, what), statuses=statuses, done=done)
    if course.purpose is Purpose.PLACE:
        return work  # what is in the hand goes back where it came from
    release = Course(Purpose.LET_GO, course.transfer, course.goal, let_go(work.tool, work.hand))
    return replace(work, course=release, carried=None)


def _pose(goal: ToolGoal) -> ToolPose:
    return ToolPose(np.array((goal.x, goal.y, goal.z)), np.array(goal.quaternion))
