"""What the dialogue has done: requests, publications, replies."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mbd_model.assists import Assist, Denial
from mbd_model.correction import StepCorrection
from mbd_model.session import Prompt, PromptKind


class Request(StrEnum):
    """What the dialogue asks another node to do."""

    OBSERVE_SOURCE = "look at the source objects"
    OBSERVE_TARGET = "look at the target objects"
    START = "start recording the demonstration"
    STOP = "stop recording the demonstration"
    DISCARD = "discard the recording"
    REVISE = "correct the demonstrated steps"


@dataclass(frozen=True)
class Call:
    """Effect: have a request done; its result comes back as RequestDone with the token, None if no one waits.

    REVISE has the correction.
    """

    request: Request
    token: int | None
    correction: StepCorrection | None = None


@dataclass(frozen=True)
class PublishAssists:
    """Effect: publish the complete list of assists and denials under a stamp [ns]."""

    assists: tuple[Assist, ...]
    stamp: int
    denials: tuple[Denial, ...] = ()


@dataclass(frozen=True)
class PublishPrompt:
    """Effect: publish a prompt for the teacher."""

    prompt: Prompt


@dataclass(frozen=True)
class ReleaseStop:
    """Effect: a person lets the robot go on after a stop."""


Effect = Call | PublishAssists | PublishPrompt | ReleaseStop


@dataclass(frozen=True)
class Reply:
    """What became of the wizard event of that topic and stamp [ns]."""

    topic: str
    stamp: int
    accepted: bool
    reason: str


def inform(text: str) -> PublishPrompt:
    """A prompt that is no question."""
    return PublishPrompt(Prompt(PromptKind.INFORM, text))
