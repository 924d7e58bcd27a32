"""The execution node in process: plans from the mapping inferred, makes motion after motion, reports, asks.

It knows what the node knows: task, target scene and estimate of the dialogue, and how motions end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from mbd_execution.choosing import next_motion
from mbd_execution.execution import assisted_again, begin, motion_ended, progress
from mbd_execution.goals import Ended, Grip, Look, Motion
from mbd_execution.hand import HandConfig
from mbd_execution.plan import Plan, plan
from mbd_execution.work.state import Work
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import ProgressReceived, Signal
from mbd_model.errors import MbdError
from mbd_model.execution_progress import Failure, Progress, Purpose, Status, Verdict
from mbd_model.objects import Role
from mbd_model.session import Phase
from mbd_model.stop import MotionError

from mbd_experiments.execution_trials.simulated_session import do
from mbd_experiments.in_process_session import InProcessSession, SessionEndedError, Tape
from mbd_experiments.simulated_participants.dialogue_loop import DialogueLoop

MAX_MOTIONS = 400
MAX_SECONDS = 1200.0


@dataclass(frozen=True)
class Watchers:
    """Who is informed of the work.

    Attributes:
        before: a motion, with the work; what it yields lets a tick pass.
        closed: the hand has, and reports whether it holds something.
        opening: the hand is about to open; whether the robot then takes what it held as placed.
    """

    before: Callable[[Work], Iterator[None]]
    closed: Callable[[bool], object]
    opening: Callable[[bool], None]


class RobotWork:
    """The robot's part of one session.

    Args:
        session: the cell's part of it.
        loop: the dialogue's.
        tape: takes the progress.
        watchers: informed of what happens.

    Attributes:
        work: what is done, and what is to be done; None before the first plan.
        asked: the failures the teacher was asked about, in order.
    """

    def __init__(self, session: InProcessSession, loop: DialogueLoop, tape: Tape, watchers: Watchers) -> None:
        self.work: Work | None = None
        self.asked: list[Failure] = []
        self._session, self._loop, self._tape, self._watchers = session, loop, tape, watchers
        self._planned_from: int | None = None
        self._reported: Progress | None = None
        self._motions = 0
        self._began = session.seconds

    def go_on(self) -> None:
        """Do what there is to do until nothing is left, or the robot needs an answer.

        Raises:
            SessionEndedError: the robot moves on and on.
        """
        while True:
            allowed = self._dialogue.phase is Phase.EXECUTE and self._plan()
            if self.work is None:
                return
            self.work, motion = next_motion(self.work, allowed)
            phase = self._dialogue.phase
            self._report()
            if self._dialogue.phase is not phase:
                continue  # the robot has asked: what it holds is put back first
            if motion is None:
                return
            self._make(motion)

    @property
    def _dialogue(self) -> Dialogue:
        return self._loop.dialogue

    def _plan(self) -> bool:
        """Whether the work comes of the present assists; plans again when it does not."""
        now = self._dialogue
        if now.belief is None or now.belief.estimate is None or now.task is None or now.target is None:
            return False
        if self._planned_from != now.assists_stamp:
            new = plan(now.task, now.target, now.belief.estimate.executed.as_dict)
            if self.work is None:
                self.work = begin(new, HandConfig(), looks=True)
            else:
                self.work = _answered(self.work, new, now)
            self._planned_from = now.assists_stamp
        return True

    def _make(self, motion: Motion) -> None:
        if self.work is None:
            return
        self._motions += 1
        if self._motions > MAX_MOTIONS or self._session.seconds - self._began > MAX_SECONDS:
            raise SessionEndedError(f"the robot moved on and on: {self._motions} motions, {progress(self.work).text}")
        for _ in self._watchers.before(self.work):
            self._session.tick()
        course = self.work.course
        if isinstance(motion, Grip) and not motion.close and course is not None:
            self._watchers.opening(course.purpose in (Purpose.PLACE, Purpose.RETURN))
        ended = self._looked() if isinstance(motion, Look) else do(motion, self._session.cell, self._session)
        self.work = motion_ended(self.work, ended)
        if isinstance(motion, Grip) and motion.close:
            self._watchers.closed(ended.holding)

    def _looked(self) -> Ended:
        """What perception sees of the table now, as its service answers it."""
        try:
            return Ended(True, seen=self._session.look(Role.TARGET).scene)
        except MbdError as error:
            return Ended(False, message=str(error), error=MotionError.NOT_REACHED)

    def _report(self) -> None:
        """What the node publishes of its progress, when it has changed."""
        if self.work is None or self._planned_from is None:
            return
        now = progress(self.work)
        if now == self._reported:
            return
        self._reported = now
        if now.status is Status.FAILED:
            self.asked.append(now.failure)
        at, stamp = self._session.now, self._planned_from
        self._tape.write("interaction/progress", (now, stamp), at)
        self._loop.feed(
            ProgressReceived(Signal.PROGRESS, at, "", now.step_index, now.status, now.text, stamp, now.failure)
        )

    @property
    def finished(self) -> bool:
        """The robot has reported the task done."""
        return self._reported is not None and self._reported.status is Status.FINISHED


def _answered(work: Work, new: Plan, now: Dialogue) -> Work:
    """The work after new assists, or after what was answered to its own question."""
    if work.failure is None or work.failure.failure in (Failure.NONE, Failure.NO_COUNTERPART):
        return assisted_again(work, new, frozenset(a.source_id for a in now.assists))
    verdict = Verdict.NONE if work.failure.step in now.skipped else now.verdict
    return assisted_again(work, new, frozenset(), verdict)
