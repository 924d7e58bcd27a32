"""What becomes of the work when one of its courses fails: another attempt, or a question to the teacher."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.execution_progress import Failure, Purpose, Status

from mbd_execution.routes import let_go
from mbd_execution.work.failures import HANDLING, trouble
from mbd_execution.work.state import Course, Work, with_status

WORDS = {
    Failure.NOT_GRASPED: "I could not {doing} {held}",
    Failure.NO_WAY: "I could not {doing} {held}",
    Failure.HAND_ZONE: "I cannot {doing} {held}",
    Failure.SLIPPED: "I lost {held} on the way",
    Failure.NOT_SEEN: "I could not look at the table",
}


def failed(work: Work, course: Course, failure: Failure, why: str) -> Work:
    """The work after one attempt of a course failed.

    Args:
        work: before.
        course: that failed.
        failure: its name.
        why: a sentence for people, without a full stop.
    """
    if course.purpose is Purpose.LET_GO:
        return replace(work, course=None)
    held, shown = course.transfer.held, course.transfer.shown
    if failure is Failure.SLIPPED:
        return _lost(work, course, why)
    if course.purpose is Purpose.LOOK:
        failure = Failure.NOT_SEEN
    attempts = work.attempts + 1
    if attempts < HANDLING[failure].limit:
        return replace(work, course=None, attempts=attempts)
    step = shown.place if course.purpose is Purpose.PLACE else shown.pick
    what = f"{WORDS[failure].format(doing=course.purpose.words, held=held)}: {why}"
    statuses = with_status(work.statuses, Status.FAILED, step)
    done = work.done[:-1] if course.purpose is Purpose.FETCH else work.done
    question = trouble(failure, step, what, held)
    work = replace(work, course=None, attempts=0, failure=question, statuses=statuses, done=done)
    if course.purpose in (Purpose.PLACE, Purpose.LOOK):
        return work  # what is in the hand goes back where it came from
    release = Course(Purpose.LET_GO, course.transfer, course.goal, let_go(work.tool, work.hand))
    return replace(work, course=release, carried=None)


def _lost(work: Work, course: Course, why: str) -> Work:
    """What was in the hand fell out of it: the next look shows where it is now, and it is picked up again."""
    carried = work.carried
    if carried is None:
        return work
    held, pick = carried.held.box.object_id, carried.transfer.shown.pick
    work, times = replace(work, carried=None, course=None, looked=False).tried(held, Failure.SLIPPED)
    if times < HANDLING[Failure.SLIPPED].limit:
        return replace(work, statuses=with_status(work.statuses, Status.PLANNED, pick))
    what = f"{WORDS[Failure.SLIPPED].format(held=held)}: {why}"
    statuses = with_status(work.statuses, Status.FAILED, pick)
    release = Course(Purpose.LET_GO, course.transfer, course.goal, let_go(work.tool, work.hand))
    return replace(work, course=release, failure=trouble(Failure.SLIPPED, pick, what, held), statuses=statuses)
