"""Phases of a study session and the prompts the robot speaks (PAPER.md section 5; paper sec. 4.2, 6.1)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from mbd_model.assists import Assist


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


class PromptKind(IntEnum):
    """What a prompt is for; values equal mbd_msgs/Prompt."""

    INFORM = 1
    WHAT_DO_I_USE = 2
    WHERE_DO_I_GO = 3


@dataclass(frozen=True)
class Prompt:
    """What the robot says to the teacher now.

    Attributes:
        kind: information, or one of the paper's two questions.
        text: the sentence.
        step_index: 0-based step it asks about, -1 for information.
        source_id: primary object of that step, "" for information.
    """

    kind: PromptKind
    text: str
    step_index: int = -1
    source_id: str = ""


@dataclass(frozen=True)
class SessionState:
    """Everything the dialogue knows, so that a node that comes back can carry on from it.

    Attributes:
        session: name of the session (also of its bag).
        phase: where it is.
        paused: True while the wizard paused it.
        step_index: 0-based step the robot asks about (ASSIST) or states (EXECUTE); -1 otherwise.
        assists: all assists in force, oldest first.
        num_events: accepted events so far.
        detail: one sentence for people.
    """

    session: str
    phase: Phase
    paused: bool = False
    step_index: int = -1
    assists: tuple[Assist, ...] = ()
    num_events: int = 0
    detail: str = ""
