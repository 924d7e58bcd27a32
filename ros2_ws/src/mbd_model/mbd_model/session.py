"""Phases of a study session and the prompts the robot speaks (PAPER.md section 5; paper sec. 4.2, 6.1)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from mbd_model.assists import Assist, Denial
from mbd_model.execution_progress import Verdict


class Phase(IntEnum):
    """Where the session is; values equal mbd_msgs/SessionState."""

    OBSERVE_SOURCE = 1
    DEMONSTRATE = 2
    TUCK_AND_CLEAR = 3
    OBSERVE_TARGET = 4
    ASSIST = 5
    EXECUTE = 6
    DONE = 7
    ABORTED = 8


class Awaited(IntEnum):
    """What the session waits for before it goes on by itself; values equal mbd_msgs/SessionState.AWAITING_*.

    UNKNOWN: recorded by a version without this field. NEXT_PHASE: the word that the table is ready, or the phase over.
    HANDED and POINTED: the answer to the question asked, about a PICK and a PLACE. TASK, TARGET_SCENE and ESTIMATE:
    facts other nodes publish. EXECUTION: the robot's end of the task. OBSERVATION and RECORDING: the answer to a
    request to look, and to start or stop recording. RESUME: the session is paused. NOTHING: it is over.
    CONFIRMATION, YES_OR_NO and ONE_OF_TWO: the answer to CONFIRM_ASSIST, IS_THIS_IT and WHICH_OF_TWO. HELP: to
    PUT_IT_RIGHT.
    """

    UNKNOWN = 0
    NOTHING = 1
    NEXT_PHASE = 2
    DEMONSTRATION_START = 3
    DEMONSTRATION_STOP = 4
    HANDED = 5
    POINTED = 6
    TASK = 7
    TARGET_SCENE = 8
    ESTIMATE = 9
    EXECUTION = 10
    OBSERVATION = 11
    RECORDING = 12
    RESUME = 13
    CONFIRMATION = 14
    YES_OR_NO = 15
    ONE_OF_TWO = 16
    HELP = 17


class PromptKind(IntEnum):
    """What a prompt is for; values equal mbd_msgs/Prompt."""

    INFORM = 1
    WHAT_DO_I_USE = 2
    WHERE_DO_I_GO = 3
    CONFIRM_ASSIST = 4
    IS_THIS_IT = 5
    WHICH_OF_TWO = 6
    WHICH_WAS_MEANT = 7
    PUT_IT_RIGHT = 8


@dataclass(frozen=True)
class Prompt:
    """The robot's prompt to the teacher.

    Attributes:
        kind: information, one of the paper's two questions, or one that names objects.
        text: the sentence; nothing may depend on its words.
        step_index: 0-based step it asks about, -1 for information.
        source_id: primary object of that step, "" for information.
        target_ids: the target objects the question names: one to be confirmed or denied, two to choose from, or none.
        source_ids: the two source objects, either of which a demonstrated step may be about; else ().
    """

    kind: PromptKind
    text: str
    step_index: int = -1
    source_id: str = ""
    target_ids: tuple[str, ...] = ()
    source_ids: tuple[str, ...] = ()


@dataclass(frozen=True)
class GripperWord:
    """A gripper command during the demonstration: when [s], and whether to close."""

    stamp: float
    close: bool


@dataclass(frozen=True)
class SessionState:
    """Everything the dialogue knows, so that a node that comes back can continue from it.

    Attributes:
        session: name of the session (also of its bag).
        phase: where it is.
        paused: True while the wizard paused it.
        step_index: 0-based step the robot asks about (ASSIST, TUCK_AND_CLEAR) or states (EXECUTE); -1 otherwise.
        assists: all assists in force, oldest first.
        num_events: accepted events so far.
        detail: one sentence for people; nothing may depend on its words.
        recording: a demonstration is being recorded.
        awaiting: what has to happen before it goes on by itself.
        denials: every "no" in force, oldest first.
        skipped: 0-based steps left without an assist, in order.
        words: gripper commands since the recording began, oldest first.
        verdict: what was answered to the last PUT_IT_RIGHT.
    """

    session: str
    phase: Phase
    paused: bool = False
    step_index: int = -1
    assists: tuple[Assist, ...] = ()
    num_events: int = 0
    detail: str = ""
    recording: bool = False
    awaiting: Awaited = Awaited.UNKNOWN
    denials: tuple[Denial, ...] = ()
    skipped: tuple[int, ...] = ()
    words: tuple[GripperWord, ...] = ()
    verdict: Verdict = Verdict.NONE
