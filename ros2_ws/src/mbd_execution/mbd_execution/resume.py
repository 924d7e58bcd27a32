"""Work that goes on after its node was killed: the statuses kept state what was done, where that led is computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mbd_model.execution_progress import Purpose, Status

from mbd_execution.choosing import next_motion
from mbd_execution.execution import begin, motion_ended
from mbd_execution.goals import Ended, Grip, MoveTo
from mbd_execution.hand import HandConfig
from mbd_execution.plan import Plan
from mbd_execution.work.state import Work, with_status


def resumed(plan: Plan, hand: HandConfig, kept: Sequence[Status], *, looks: bool = False) -> Work:
    """The work of a plan whose steps had these statuses: its motions are played through in mind up to there.

    Args:
        plan: the same as before.
        hand: the hand's measures.
        kept: status of each step; another number of them is of another task and is ignored.
        looks: the table is looked at again before every step.
    """
    work = begin(plan, hand)
    if len(kept) != plan.num_steps:
        return replace(work, looks=looks)
    given_up = frozenset(t.shown.pick for t in plan.transfers if kept[t.shown.pick] is Status.LEFT_OUT)
    work = replace(work, left_out=given_up)
    for step, status in enumerate(kept):
        if status is Status.LEFT_OUT:
            work = replace(work, statuses=with_status(work.statuses, status, step))
    while (following := work.next_transfer) is not None and not following.problem:
        if kept[following.shown.pick] is not Status.DONE:
            break
        work = _through(work, Purpose.PICK)
        if kept[following.shown.place] is not Status.DONE:
            break  # it is in the hand
        work = _through(work, Purpose.PLACE)
    # Where the tool is now nobody knows.
    return replace(work, course=None, tool=None, looks=looks, looked=False, parked=False)


def _through(work: Work, purpose: Purpose) -> Work:
    """The work after one course that went well, up to the hand's closing or opening."""
    work = replace(work, course=None)
    while True:
        work, motion = next_motion(work, allowed=True)
        if motion is None or work.course is None:
            return work
        reached = motion.goal if isinstance(motion, MoveTo) else None
        decisive = isinstance(motion, Grip) and motion.close is (purpose is Purpose.PICK)
        work = motion_ended(work, Ended(True, holding=True, reached=reached))
        if decisive:
            return work
