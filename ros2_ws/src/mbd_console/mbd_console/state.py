"""What the console shows: one frozen value, and the pure functions that each thing received changes it by."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mbd_model.camera.view import CameraView
from mbd_model.estimate import MappingEstimate
from mbd_model.execution_progress import Progress, Status
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.room.device_report import DeviceReport
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep

from mbd_console.room.shown import ShownFilm, on_device_report
from mbd_console.status.event_log import LOG_LENGTH, LogLine, Tone
from mbd_console.status.recorder import NO_REPORT, RecorderState
from mbd_console.study.board import NOTHING_YET, StudyBoard
from mbd_console.study.offered import OfferedSession

PlaneCoefficients = tuple[float, float, float, float]


@dataclass(frozen=True)
class Confidence:
    """One point of the confidence's history.

    Attributes:
        at: when it was received [s, wall clock].
        value: the confidence.
        num_assists: it came of.
    """

    at: float
    value: float
    num_assists: int


@dataclass(frozen=True)
class ConsoleState:
    """Everything the pages show.

    Attributes:
        session: state of the dialogue; None before it was received.
        began, phase_began: when the session and its phase began [s, session clock].
        prompt: of the robot, and ``question``, how many it has published: an answer names the one it answers.
        closed: whether the gripper was last commanded to close; None before any command.
        source, target: the scenes, and ``planes``, the tables they stand on, by role.
        recorded: the demonstration as recorded so far; ``task``: as it was understood in the end.
        estimate: what the mapping infers; ``threshold`` and ``confident`` come with it.
        confidences: its history, oldest first.
        progress: how far the robot has got with the execution; None before it was published.
        word, speech: code (Speech.msg) of what the simulated teacher said last, and its words; 0 and "" for nothing.
        standing: why everything stands until a person resumes, "" while it does not.
        view: the camera; None before its optics were received.
        recorder: what the recorder reports.
        filmed: the films of the room by devices.
        study: forms, checklist, countdown.
        offered: the session that the plan has next, None where nobody offers one.
        log: newest first.
    """

    session: SessionState | None = None
    began: float = 0.0
    phase_began: float = 0.0
    prompt: Prompt | None = None
    question: int = 0
    closed: bool | None = None
    source: Scene | None = None
    target: Scene | None = None
    planes: tuple[tuple[Role, PlaneCoefficients], ...] = ()
    recorded: Task | None = None
    task: Task | None = None
    estimate: MappingEstimate | None = None
    threshold: float = 0.0
    confident: bool = False
    confidences: tuple[Confidence, ...] = ()
    progress: Progress | None = None
    word: int = 0
    speech: str = ""
    standing: str = ""
    view: CameraView | None = None
    recorder: RecorderState = NO_REPORT
    filmed: tuple[ShownFilm, ...] = ()
    study: StudyBoard = NOTHING_YET
    offered: OfferedSession | None = None
    log: tuple[LogLine, ...] = ()

    @property
    def phase(self) -> Phase | None:
        """Where the session is."""
        return self.session.phase if self.session else None

    @property
    def recording(self) -> bool:
        """A demonstration is being recorded."""
        return self.session is not None and self.session.recording

    @property
    def steps(self) -> tuple[TaskStep, ...]:
        """The demonstrated steps: of the recording while it runs, else of the task."""
        shown = self.recorded if self.recording else self.task
        return shown.steps if shown else ()

    @property
    def asked(self) -> TaskStep | None:
        """The step the robot asks about; None while it asks nothing."""
        session = self.session
        if session is None or session.phase is not Phase.ASSIST or not 0 <= session.step_index < len(self.steps):
            return None
        return self.steps[session.step_index]

    @property
    def candidates(self) -> tuple[str, ...]:
        """The two source objects, either of which the step asked about may be about; () while that is not asked."""
        session, prompt = self.session, self.prompt
        if session is None or prompt is None or session.phase is not Phase.TUCK_AND_CLEAR or session.step_index < 0:
            return ()
        return prompt.source_ids if prompt.kind is PromptKind.WHICH_WAS_MEANT else ()

    @property
    def on_table(self) -> tuple[SceneObject, ...]:
        """The objects that stand where they were seen, for outlines on the live picture."""
        if self.phase is Phase.DEMONSTRATE and self.source:
            moved = {s.primary_object for s in self.steps if s.kind is StepKind.PICK}
            return tuple(o for o in self.source.objects if o.object_id not in moved)
        if self.phase in (Phase.ASSIST, Phase.EXECUTE) and self.target:
            return tuple(o for o in self.target.objects if o.object_id not in self._moved_alone)
        return ()

    @property
    def step_statuses(self) -> tuple[Status, ...]:
        """How far the robot is with each step of its execution; () when there is none, or of another task."""
        if self.progress is None or self.phase not in (Phase.ASSIST, Phase.EXECUTE, Phase.DONE):
            return ()
        statuses = self.progress.step_statuses
        return statuses if len(statuses) == len(self.steps) else ()

    @property
    def _moved_alone(self) -> frozenset[str]:
        """Target objects the robot has taken from where they were seen."""
        if self.phase is not Phase.EXECUTE or self.estimate is None:
            return frozenset()
        begun = [
            step.primary_object
            for step, status in zip(self.steps, self.step_statuses, strict=False)
            if step.kind is StepKind.PICK and status in (Status.UNDER_WAY, Status.DONE)
        ]
        mapping = self.estimate.executed.as_dict
        return frozenset(mapping[source] for source in begun if source in mapping)

    def plane(self, role: Role) -> PlaneCoefficients:
        """(a, b, c, d) of the table [m, base frame] in a scene; z = 0 where perception did not state."""
        return dict(self.planes).get(role, (0.0, 0.0, 1.0, 0.0))


def logged(state: ConsoleState, at: float, tone: Tone, speaker: str, text: str) -> ConsoleState:
    """The state with another line in its log."""
    return replace(state, log=(LogLine(at, tone, speaker, text), *state.log)[:LOG_LENGTH])


def phase_name(phase: Phase) -> str:
    """A phase in words."""
    return phase.name.replace("_", " ").capitalize()


def on_session(state: ConsoleState, session: SessionState, at: float) -> ConsoleState:
    """The dialogue's state came, stamped ``at`` [s]."""
    known = state.session if state.session and state.session.session == session.session else None
    if known is None:  # nothing of another session may be shown as if it were of this one
        kept = ConsoleState(
            view=state.view,
            log=state.log,
            prompt=state.prompt,
            question=state.question,
            standing=state.standing,
            recorder=state.recorder,
            filmed=state.filmed,
        )
        if state.session is None:
            kept = state
        state = replace(kept, began=at)
    changed = known is None or known.phase is not session.phase
    shown = replace(state, session=session, phase_began=at if changed else state.phase_began)
    if shown.recording and not state.recording and known is not None:
        shown = replace(shown, recorded=None)  # what was recorded before is of another attempt
    return logged(shown, at, Tone.PHASE, "phase", phase_name(session.phase)) if changed else shown


def on_prompt(state: ConsoleState, prompt: Prompt, at: float) -> ConsoleState:
    """The robot published a prompt."""
    spoken = replace(state, prompt=prompt, question=state.question + 1)
    return logged(spoken, at, Tone.ROBOT, "robot", prompt.text)


def on_scene(state: ConsoleState, scene: Scene, plane: PlaneCoefficients) -> ConsoleState:
    """A scene was observed."""
    known = plane if any(plane) else (0.0, 0.0, 1.0, 0.0)
    planes = tuple({**dict(state.planes), scene.role: known}.items())
    if scene.role is Role.SOURCE:
        return replace(state, source=scene, planes=planes)
    return replace(state, target=scene, planes=planes)


def on_recorded(state: ConsoleState, task: Task) -> ConsoleState:
    """The recording of the demonstration went on."""
    return replace(state, recorded=task)


def on_task(state: ConsoleState, task: Task) -> ConsoleState:
    """A demonstration was understood."""
    return replace(state, task=task)


def on_estimate(
    state: ConsoleState, estimate: MappingEstimate, threshold: float, confident: bool, at: float
) -> ConsoleState:
    """The mapping inferred something at ``at`` [s, wall clock]; one published again is no new point of the history."""
    history = state.confidences
    if estimate != state.estimate:
        history = (*history, Confidence(at, estimate.confidence, estimate.num_assists))
    return replace(state, estimate=estimate, threshold=threshold, confident=confident, confidences=history)


def on_progress(state: ConsoleState, progress: Progress, session: str, at: float) -> ConsoleState:
    """The robot got on with executing the task; what it reports of another session is of no interest."""
    if state.session is not None and state.session.session != session:
        return state
    shown = replace(state, progress=progress)
    same = state.progress is not None and state.progress.doing == progress.doing
    return shown if same or not progress.text else logged(shown, at, Tone.ROBOT, "robot", progress.text)


def on_reply(state: ConsoleState, topic: str, accepted: bool, reason: str, at: float) -> ConsoleState:
    """A wizard event was answered."""
    what = topic.rpartition("wizard/")[2]
    if accepted and what in ("demonstration", "command"):
        state = replace(state, word=0, speech="")
    return logged(state, at, Tone.ACCEPTED if accepted else Tone.REFUSED, what, reason)


def on_gripper(state: ConsoleState, close: bool) -> ConsoleState:
    """The gripper was commanded to close or to open, by whomever."""
    return replace(state, closed=close, word=0, speech="")


def on_note(state: ConsoleState, text: str, at: float) -> ConsoleState:
    """Somebody wrote a note."""
    return logged(state, at, Tone.NOTE, "note", text)


def on_recorder(state: ConsoleState, recorder: RecorderState) -> ConsoleState:
    """The recorder reported."""
    return replace(state, recorder=recorder)


def on_filmed(state: ConsoleState, report: DeviceReport, now: float, at: float) -> ConsoleState:
    """A device that films the room reported, at ``now`` [s, steady clock], ``at`` [s, session clock]."""
    known = {film.name: film.refused for film in state.filmed}
    shown = replace(state, filmed=on_device_report(state.filmed, report, now))
    if report.lost and not known.get(report.name):
        return logged(shown, at, Tone.REFUSED, "room", f"{report.name}: {report.lost}")
    return shown


def on_offered(state: ConsoleState, offered: OfferedSession) -> ConsoleState:
    """What leads the session stated which is next."""
    return replace(state, offered=offered)


def on_study(state: ConsoleState, study: StudyBoard) -> ConsoleState:
    """A form was shown or came back, something was ticked, a countdown began or ended."""
    return replace(state, study=study)


def on_speech(state: ConsoleState, word: int, words: str, at: float) -> ConsoleState:
    """The simulated teacher said something; until it is acted on it may be said again and again."""
    if word == state.word:
        return state
    return logged(replace(state, word=word, speech=words), at, Tone.TEACHER, "teacher", words)


def on_stop(state: ConsoleState, standing: str, at: float) -> ConsoleState:
    """The robot was stopped, ``standing`` says why; or, with "", a person let it go on."""
    if standing == state.standing:
        return state
    text = standing or "a person let the robot go on"
    return logged(replace(state, standing=standing), at, Tone.REFUSED if standing else Tone.ACCEPTED, "stop", text)


def on_view(state: ConsoleState, view: CameraView) -> ConsoleState:
    """The camera's optics became known."""
    return replace(state, view=view)


def asks(prompt: Prompt | None) -> bool:
    """Whether a prompt is a question."""
    return prompt is not None and prompt.kind is not PromptKind.INFORM
