"""The state of the dialogue, and what a transition makes of it: a new state, effects, a reply."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from mbd_model.assists import Assist, Denial
from mbd_model.correction import StepCorrection
from mbd_model.errors import MbdError
from mbd_model.execution_progress import Status, Verdict
from mbd_model.objects import Scene
from mbd_model.session import Awaited, GripperWord, Phase, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep

from mbd_interaction.config import DialogueConfig
from mbd_interaction.effects import Effect, PublishAssists, Reply, Request
from mbd_interaction.events import EstimateReceived, ProgressReceived


class EventRefusedError(MbdError):
    """An event the dialogue cannot take now. The text states why and what it would take."""


AWAITED_OF_REQUEST = {
    Request.OBSERVE_SOURCE: Awaited.OBSERVATION,
    Request.OBSERVE_TARGET: Awaited.OBSERVATION,
    Request.START: Awaited.RECORDING,
    Request.STOP: Awaited.RECORDING,
    Request.DISCARD: Awaited.RECORDING,
    Request.REVISE: Awaited.RECORDING,
}


AWAITED_OF_QUESTION = {
    PromptKind.CONFIRM_ASSIST: Awaited.CONFIRMATION,
    PromptKind.IS_THIS_IT: Awaited.YES_OR_NO,
    PromptKind.WHICH_OF_TWO: Awaited.ONE_OF_TWO,
    PromptKind.PUT_IT_RIGHT: Awaited.HELP,
}


@dataclass(frozen=True)
class AskedQuestion:
    """What is asked: how, and about which target or source objects besides."""

    kind: PromptKind
    target_ids: tuple[str, ...] = ()
    source_ids: tuple[str, ...] = ()


@dataclass(frozen=True)
class AnswerTaken:
    """A yes or no that was taken, so that it can be undone.

    Attributes:
        before: the assists and denials before it.
        after: those it made.
        step_index: of the step it was about.
    """

    before: tuple[tuple[Assist, ...], tuple[Denial, ...]]
    after: tuple[tuple[Assist, ...], tuple[Denial, ...]]
    step_index: int


@dataclass(frozen=True)
class StandingStill:
    """Nothing moves, not even the hand, until a person resumes; ``reason`` is for people."""

    reason: str


@dataclass(frozen=True)
class Pending:
    """A request under way; its result answers the wizard event of ``topic`` and ``stamp`` [ns].

    REVISE has the correction.
    """

    request: Request
    token: int
    topic: str
    stamp: int
    correction: StepCorrection | None = None


@dataclass(frozen=True)
class Dialogue:
    """Everything the dialogue knows.

    Attributes:
        session, phase, paused, step_index, assists, num_events, detail, recording, denials, words: as in SessionState.
        config: how it behaves.
        pending: the request under way.
        token: the last request's number.
        task, task_stamp: the demonstrated task and its stamp [ns].
        target, target_stamp: the target scene and its stamp [ns].
        last_estimate: the last estimate, whatever it came of.
        assists_stamp: stamp [ns] of the list of assists as last published.
        skipped: steps left without an assist.
        insist: step to ask about whatever the confidence, -1 for none: its assist was withdrawn.
        progress: how far the robot was when it last reported.
        question: how the step asked about is asked; None when nothing is.
        kept_unconfirmed: (source id, target id) of assists that were asked about, skipped, and hold as given.
        yes_or_no: every yes and no taken, oldest first.
        asked_at: when the present question was asked [ns]; an answer older than it is late.
        left_in_doubt: ends [s] of the steps that the teacher was asked about and left in doubt.
        verdict: what was answered to the last PUT_IT_RIGHT.
        standing: why the robot stands still until a person resumes; None while it does not.
        aborted_from: the phase in which the session was aborted; None when it was not, or before a restart.
    """

    session: str
    phase: Phase = Phase.OBSERVE_SOURCE
    paused: bool = False
    step_index: int = -1
    assists: tuple[Assist, ...] = ()
    num_events: int = 0
    detail: str = ""
    config: DialogueConfig = field(default_factory=DialogueConfig)
    recording: bool = False
    pending: Pending | None = None
    token: int = 0
    task: Task | None = None
    task_stamp: int = 0
    target: Scene | None = None
    target_stamp: int = 0
    last_estimate: EstimateReceived | None = None
    assists_stamp: int = 0
    skipped: frozenset[int] = frozenset()
    insist: int = -1
    asked_at: int = 0
    progress: ProgressReceived | None = None
    denials: tuple[Denial, ...] = ()
    question: AskedQuestion | None = None
    kept_unconfirmed: frozenset[tuple[str, str]] = frozenset()
    yes_or_no: tuple[AnswerTaken, ...] = ()
    left_in_doubt: frozenset[float] = frozenset()
    words: tuple[GripperWord, ...] = ()
    standing: StandingStill | None = None
    aborted_from: Phase | None = None
    verdict: Verdict = Verdict.NONE

    @property
    def belief(self) -> EstimateReceived | None:
        """The estimate that came of exactly the present task, target scene and assists; None while it is awaited."""
        now = (self.task_stamp, self.target_stamp, self.assists_stamp)
        last = self.last_estimate
        if last and now == (last.task_stamp, last.scene_stamp, last.assists_stamp):
            return last
        return None

    @property
    def present_progress(self) -> ProgressReceived | None:
        """The robot's progress with what the present assists state; None when it has not begun with that."""
        received = self.progress
        return received if received and received.assists_stamp == self.assists_stamp else None

    @property
    def executed(self) -> bool:
        """Whether nothing is left for the robot to do, or no robot does it."""
        now = self.present_progress
        return not self.config.execute or (now is not None and now.status is Status.FINISHED)

    @property
    def steps(self) -> tuple[TaskStep, ...]:
        """Steps of the task, () before there is one."""
        return self.task.steps if self.task else ()

    @property
    def open_steps(self) -> tuple[TaskStep, ...]:
        """Steps that may still be asked about: not skipped, and no assist is about their primary object."""
        assisted = {a.source_id for a in self.assists}
        return tuple(s for s in self.steps if s.primary_object not in assisted and s.index not in self.skipped)

    @property
    def awaiting(self) -> Awaited:
        """What has to happen before the session goes on by itself."""
        if self.phase in (Phase.DONE, Phase.ABORTED):
            return Awaited.NOTHING
        if self.paused:
            return Awaited.RESUME
        if self.pending:
            return AWAITED_OF_REQUEST[self.pending.request]
        if self.phase is Phase.DEMONSTRATE:
            return Awaited.DEMONSTRATION_STOP if self.recording else Awaited.DEMONSTRATION_START
        if self.phase is Phase.ASSIST:
            return self._awaiting_in_assist
        return Awaited.EXECUTION if self.phase is Phase.EXECUTE and not self.executed else Awaited.NEXT_PHASE

    @property
    def _awaiting_in_assist(self) -> Awaited:
        if 0 <= self.step_index < len(self.steps):
            if self.question and self.question.kind in AWAITED_OF_QUESTION:
                return AWAITED_OF_QUESTION[self.question.kind]
            return Awaited.HANDED if self.steps[self.step_index].kind is StepKind.PICK else Awaited.POINTED
        if self.task is None:
            return Awaited.TASK
        return Awaited.TARGET_SCENE if self.target is None else Awaited.ESTIMATE

    @property
    def state(self) -> SessionState:
        """What is published and kept of it."""
        return SessionState(
            session=self.session,
            phase=self.phase,
            paused=self.paused,
            step_index=self.step_index,
            assists=self.assists,
            num_events=self.num_events,
            detail=self.detail,
            recording=self.recording,
            awaiting=self.awaiting,
            denials=self.denials,
            skipped=tuple(sorted(self.skipped)),
            words=self.words,
            verdict=self.verdict,
        )


@dataclass(frozen=True)
class Outcome:
    """What an event does.

    Attributes:
        dialogue: the state after it.
        effects: to be performed in order.
        confirmation: the accepting reply's reason; None when the reply comes later (a request's result) or none waits.
        reply: the complete reply, filled in by ``transition``.
    """

    dialogue: Dialogue
    effects: tuple[Effect, ...] = ()
    confirmation: str | None = None
    reply: Reply | None = None


def enter(dialogue: Dialogue, phase: Phase, detail: str) -> Dialogue:
    """The dialogue in another phase, asking nothing yet."""
    return replace(dialogue, phase=phase, step_index=-1, question=None, insist=-1, detail=detail)


def with_assists(
    dialogue: Dialogue, assists: tuple[Assist, ...], at: int, denials: tuple[Denial, ...] | None = None
) -> tuple[Dialogue, PublishAssists]:
    """The dialogue with another list of assists, and its publication under a stamp [ns] no earlier list had.

    Args:
        dialogue: before.
        assists: the complete list.
        at: now [ns].
        denials: the complete list; None: as they were, but for what an assist now claims.
    """
    stamp = max(at, dialogue.assists_stamp + 1)
    claimed = {(a.source_id, a.target_id) for a in assists}
    kept = dialogue.denials if denials is None else denials
    kept = tuple(d for d in kept if (d.source_id, d.target_id) not in claimed)
    changed = replace(
        dialogue,
        assists=assists,
        denials=kept,
        assists_stamp=stamp,
        kept_unconfirmed=dialogue.kept_unconfirmed & claimed,
    )
    return changed, PublishAssists(assists, stamp, kept)
