"""One trial: a complete session of perceived objects, inferred mapping and scripted teacher, and the robot's work.

The system is given what a camera and a hand give; the simulation's truth is for the teacher, who sees the table, for
the adversary, and for the judge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from mbd_cell.adversary import ADVERSARY_STREAM, Adversary, TableDisturbance
from mbd_cell.cell import Cell
from mbd_cell.layout.object_sets import drawn_scenes
from mbd_cell.layout.scenes import ObjectSpec, Shape, TaskScenes
from mbd_cell.outcome import object_states
from mbd_execution.work.state import Work
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue
from mbd_mapping.parameters import MAPPING, mapping_config
from mbd_model.errors import MbdError
from mbd_model.execution_progress import Status
from mbd_model.objects import Role
from mbd_model.session import Phase
from mbd_perception.features.measure import ObserveConfig
from numpy.typing import NDArray

from mbd_experiments.execution_trials.evidence import photograph
from mbd_experiments.execution_trials.judging import judge
from mbd_experiments.execution_trials.referee import Referee
from mbd_experiments.execution_trials.result import TrialCase, TrialResult
from mbd_experiments.execution_trials.robot_work import RobotWork, Watchers
from mbd_experiments.execution_trials.teacher_errors import drawn_errors
from mbd_experiments.execution_trials.trial_teacher import TrialTeacher
from mbd_experiments.in_process_session import SessionEndedError, Tape
from mbd_experiments.simulated_participants.error_model import Slip
from mbd_experiments.simulated_participants.script import participant_script
from mbd_experiments.simulated_participants.session import ParticipantSession, Settings

LATE_STREAM, LATEST = 34, 1.5  # of chance; [s] of a word to the hand
SETTLING = 1.0  # [s] until what was let go has come to rest
ACTS_FROM = 6  # the adversary waits for some of this many motions, so that he acts anywhere in the work
SPARES = ((Shape.BOX, (0.07, 0.044, 0.034), 0.06), (Shape.CUP, (0.06, 0.06, 0.075), 0.06))


@dataclass(frozen=True)
class Tried:
    """A trial with the pictures for who wants to see what happened: (H, W, 3) RGB, None when it never got there."""

    result: TrialResult
    before: NDArray[np.uint8] | None = None
    after: NDArray[np.uint8] | None = None


def trial_scenes(shipped: TaskScenes, seed: int) -> TaskScenes:
    """The sets of one trial: newly drawn, with something to be added by an adversary."""
    rng = np.random.default_rng([seed, ADVERSARY_STREAM, 1])
    shape, size, mass = SPARES[int(rng.integers(len(SPARES)))]
    spare = ObjectSpec("spare", shape, size, round(float(rng.uniform(0.0, 359.0)), 1), mass)
    return replace(drawn_scenes(shipped, seed), spares=(spare,))


def trial_settings(case: TrialCase, perception: ObserveConfig) -> Settings:
    """How the system of a trial is set: as the nodes of a session are by default, with a robot that executes."""
    mapping = mapping_config(MAPPING.values())
    threshold = mapping.stop_at if case.threshold is None else case.threshold
    return Settings(perception, mapping, threshold, DialogueConfig(execute=True), case.grasp)


class TrialSession:
    """Runs one trial.

    Args:
        case: which.
        shipped: the scene file of its task.
        perception: how scenes are seen.
        tape: takes everything that happens.

    Attributes:
        case: which.
    """

    def __init__(self, case: TrialCase, shipped: TaskScenes, perception: ObserveConfig, tape: Tape) -> None:
        errors = drawn_errors(case.task, case.seed, case.teacher_errors)
        script = participant_script(trial_scenes(shipped, case.seed), errors)
        self.case, self._errors, self._scenes = case, errors, script.scenes
        self._adversary: Adversary | None = None
        self._teacher = TrialTeacher(script, TableDisturbance.LIE in case.disturbances)
        self._session = ParticipantSession(
            case.name, script, case.seed, trial_settings(case, perception), tape, answering=self._teacher
        )
        self._session.cell_session.fingers = True
        if Slip.LATE in errors.slips:
            late = np.random.default_rng([case.seed, LATE_STREAM])
            self._session.cell_session.lateness = lambda: float(late.uniform(0.0, LATEST))
        self._tape = tape
        self._rng = np.random.default_rng([case.seed, ADVERSARY_STREAM])
        self._patience = int(self._rng.integers(ACTS_FROM))

    @property
    def cell(self) -> Cell:
        """The cell it happens in."""
        return self._session.cell_session.cell

    @property
    def dialogue(self) -> Dialogue:
        """Where the dialogue is."""
        return self._session.loop.dialogue

    @property
    def disturbed(self) -> list[str]:
        """What the adversary has done so far, the teacher's lie included, in words."""
        done = self._adversary.done if self._adversary else []
        return [d.words for d in done] + (["the teacher lied"] if self._teacher.lied else [])

    def watch(self, watcher: Callable[[], None]) -> None:
        """Have a function called after each control tick from now on."""
        self._session.cell_session.watchers.append(watcher)

    def run(self) -> Tried:
        """The complete trial; a session that cannot go on is a result too."""
        try:
            self._session.prepare()
        except MbdError as error:
            return Tried(self._not_begun(f"did not come to the robot's work: {error}"))
        cell = self.cell
        before, began, self._answered_before = photograph(cell), self._session.seconds, self._session.answers
        self._adversary = self._teacher.adversary = Adversary(cell, self.case.disturbances, self._rng)
        self._referee = Referee(cell)
        self.watch(self._referee.tick)
        watchers = Watchers(self._disturb, self._referee.closed, self._referee.opening)
        robot = RobotWork(self._session.cell_session, self._session.loop, self._tape, watchers)
        self._teacher.work = lambda: robot.work
        stuck = ""
        try:
            self._work_through(robot)
        except MbdError as error:
            stuck = str(error)
        seconds = self._session.seconds - began
        self._referee.rest()
        cell.stop()
        self._session.cell_session.pass_time(SETTLING)
        return Tried(self._judged(robot, stuck, seconds), before, photograph(cell))

    def _judged(self, robot: RobotWork, stuck: str, seconds: float) -> TrialResult:
        referee = self._referee
        verdict = judge(self._scenes, self._session.left, object_states(self.cell.simulation))
        missing = _left_out(robot.work)
        return TrialResult(
            self.case.task,
            self.case.seed,
            self.case.conditions,
            right=verdict.right and not stuck and not missing,
            places_right=sum(p.success for p in verdict.places),
            places=len(verdict.places),
            assists=self._session.answers,
            at_work=self._session.answers - self._answered_before,
            disturbed="; ".join(self.disturbed),
            asked=", ".join(f.name.lower() for f in robot.asked),
            mended=", ".join(self._teacher.mended),
            errors=", ".join(self._errors.slips),
            dropped=len(referee.dropped),
            unnoticed=len(referee.unnoticed),
            arm_table=len(referee.arm_table),
            arm_objects=len(referee.arm_objects),
            seconds=round(seconds, 1),
            why="; ".join(reason for reason in (stuck, missing, verdict.wrong) if reason),
        )

    def _work_through(self, robot: RobotWork) -> None:
        loop = self._session.loop
        while True:
            robot.go_on()
            if loop.dialogue.phase is Phase.ASSIST:
                self._session.answer()
            elif robot.finished:
                self._session.next_phase()
                return
            else:
                raise SessionEndedError(f"the robot stands still in {loop.dialogue.phase.name}: {loop.dialogue.detail}")

    def _disturb(self, work: Work) -> Iterator[None]:
        """Before a motion: what the hand may touch, and the adversary's turn."""
        names = self._session.true_names[Role.TARGET]
        self._referee.handles(work)
        if self._patience > 0:
            self._patience -= 1
            return
        coming = work.wanted[len(work.done) :]
        wanted = {names.get(i or "", "") for t in coming for i in (t.held, t.receiver)}
        if self._adversary is not None:
            yield from self._adversary.act(wanted)

    def _not_begun(self, why: str) -> TrialResult:
        return TrialResult(
            self.case.task,
            self.case.seed,
            self.case.conditions,
            right=False,
            assists=self._session.answers,
            errors=", ".join(self._errors.slips),
            why=why,
        )


def _left_out(work: Work | None) -> str:
    steps = [str(i + 1) for i, s in enumerate(work.statuses) if s is Status.LEFT_OUT] if work else []
    many = len(steps) > 1
    return f"step{'s' * many} {' and '.join(steps)} {'were' if many else 'was'} left out" if steps else ""
