"""What a session was, as its bag holds it: every input and output of the mapping, and what led there."""

from __future__ import annotations

from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from mbd_model.assists import Assist, Denial
from mbd_model.estimate import EstimateInputs, MappingEstimate
from mbd_model.objects import Role, Scene
from mbd_model.session import Prompt, SessionState
from mbd_model.task import Task

Value = TypeVar("Value")


@dataclass(frozen=True)
class Recorded(Generic[Value]):
    """A value with its times.

    Attributes:
        value: what was published.
        stamp: the message's own stamp, which names it as an input [ns].
        log_time: when it was recorded [ns].
    """

    value: Value
    stamp: int
    log_time: int


@dataclass(frozen=True)
class TrueObject:
    """A simulated object as it really is.

    Attributes:
        name: as the scene file calls it.
        centroid: (x, y, z) of its centre [m, robot base frame].
        size: (width along y, depth along x, height along z) [m].
        hue: [deg], None when it has none.
    """

    name: str
    centroid: tuple[float, float, float]
    size: tuple[float, float, float]
    hue: float | None


@dataclass(frozen=True)
class Truth:
    """What the simulated cell knows of its table; empty for a real one.

    Attributes:
        task: name of the task.
        role: which set is on the table.
        seed: that it was laid from.
        objects: on the table.
        solution: right target names by source name.
    """

    task: str
    role: Role
    seed: int
    objects: tuple[TrueObject, ...]
    solution: MappingType[str, frozenset[str]]


@dataclass(frozen=True)
class RecordedReply:
    """What became of one wizard event: its topic, whether it was accepted, and why (not)."""

    topic: str
    accepted: bool
    reason: str


@dataclass(frozen=True)
class RecordedSession:
    """One session; every list is in the order recorded.

    Attributes:
        name: of the session.
        facts: what is true of all of it, see `session_facts`.
        problems: what the bag lacks, a sentence each.
        source_scenes, target_scenes: what perception saw.
        tasks: what was demonstrated.
        assists: each list of assists in force.
        denials: each list of denials, published with the assists of the same place; () when nothing was ever denied.
        estimates: with the inputs each came from.
        prompts, states, replies, notes, truths: what else was published.
    """

    name: str
    facts: MappingType[str, str] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    source_scenes: tuple[Recorded[Scene], ...] = ()
    target_scenes: tuple[Recorded[Scene], ...] = ()
    tasks: tuple[Recorded[Task], ...] = ()
    assists: tuple[Recorded[tuple[Assist, ...]], ...] = ()
    denials: tuple[Recorded[tuple[Denial, ...]], ...] = ()
    estimates: tuple[tuple[Recorded[MappingEstimate], EstimateInputs], ...] = ()
    prompts: tuple[Recorded[Prompt], ...] = ()
    states: tuple[Recorded[SessionState], ...] = ()
    replies: tuple[Recorded[RecordedReply], ...] = ()
    notes: tuple[Recorded[str], ...] = ()
    truths: tuple[Recorded[Truth], ...] = ()
