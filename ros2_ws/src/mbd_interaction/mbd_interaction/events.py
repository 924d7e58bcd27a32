"""What can happen to the dialogue: the wizard's words, results of requests, and facts received on topics.

Times are integer nanoseconds: stamps identify inputs (which estimate came of which assists), so they are never rounded.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mbd_model.correction import StepCorrection
from mbd_model.estimate import MappingEstimate
from mbd_model.execution_progress import Failure, Status
from mbd_model.objects import Scene
from mbd_model.task import Task

# [ns] by which the clocks of two nodes may differ (a simulated clock ticks); people answer more slowly than this.
CLOCK_TOLERANCE = 250_000_000


class Signal(StrEnum):
    """The kinds of event; the columns of the dialogue's table."""

    START = "start demonstration"
    STOP = "stop demonstration"
    HANDED = "handed"
    POINTED = "pointed"
    YES = "yes"
    NO = "no"
    OVERWRITE = "overwrite"
    REVISE = "revise"
    NEXT_PHASE = "next phase"
    UNDO = "undo"
    SKIP = "skip"
    PAUSE = "pause"
    RESUME = "resume"
    ABORT = "abort"
    BACK = "back"
    REDO = "redo"
    GRIPPER = "gripper"
    NOTE = "note"
    UNREADABLE = "unreadable"
    REQUEST_DONE = "request done"
    TASK = "task received"
    TARGET = "target scene received"
    ESTIMATE = "estimate received"
    OVERDUE = "estimate overdue"
    PROGRESS = "progress received"
    STOPPED = "robot stopped"


INTERNAL = frozenset(
    {
        Signal.REQUEST_DONE,
        Signal.TASK,
        Signal.TARGET,
        Signal.ESTIMATE,
        Signal.OVERDUE,
        Signal.PROGRESS,
        Signal.STOPPED,
    }
)
WIZARD = tuple(s for s in Signal if s not in INTERNAL)


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes:
        signal: its kind.
        at: when [ns].
        topic: the wizard topic it came on, which its reply names; "" for what no person did.
    """

    signal: Signal
    at: int
    topic: str = ""


@dataclass(frozen=True)
class Answered(Event):
    """HANDED or POINTED: the target object, or (``object_id`` empty) a place (x, y, z) [m, robot base frame]."""

    object_id: str = ""
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Overwritten(Event):
    """OVERWRITE: the target object meant at step ``step_index`` (0-based)."""

    step_index: int = 0
    object_id: str = ""


@dataclass(frozen=True)
class Revised(Event):
    """REVISE: a step of the demonstrated task is to be corrected."""

    correction: StepCorrection | None = None


@dataclass(frozen=True)
class Gripped(Event):
    """GRIPPER: whether it was commanded to close."""

    close: bool = False


@dataclass(frozen=True)
class Unreadable(Event):
    """UNREADABLE: a wizard message without a meaning; ``reason`` states what was expected."""

    reason: str = ""


@dataclass(frozen=True)
class RequestDone(Event):
    """REQUEST_DONE: the request of that token ended. ``scene`` and its stamp [ns] come with a successful look."""

    token: int = 0
    success: bool = False
    message: str = ""
    scene: Scene | None = None
    scene_stamp: int = 0


@dataclass(frozen=True)
class TaskReceived(Event):
    """TASK: the latched task and its stamp [ns]."""

    task: Task | None = None
    stamp: int = 0


@dataclass(frozen=True)
class TargetReceived(Event):
    """TARGET: the latched target scene and its stamp [ns]."""

    scene: Scene | None = None
    stamp: int = 0


@dataclass(frozen=True)
class EstimateReceived(Event):
    """ESTIMATE: what the mapping infers, and the stamps [ns] of the inputs it did it from.

    Attributes:
        estimate: what it infers.
        sure: its confidence reached the threshold; the robot would go on alone but for an assist it doubts.
        task_stamp, scene_stamp, assists_stamp: of the inputs.
    """

    estimate: MappingEstimate | None = None
    sure: bool = False
    task_stamp: int = 0
    scene_stamp: int = 0
    assists_stamp: int = 0


@dataclass(frozen=True)
class ProgressReceived(Event):
    """PROGRESS: how far the robot is with the execution, and the stamp [ns] of the assists its plan comes from.

    ``failure`` of a FAILED step: what went wrong.
    """

    step_index: int = -1
    status: Status = Status.PLANNED
    text: str = ""
    assists_stamp: int = 0
    failure: Failure = Failure.NONE


@dataclass(frozen=True)
class Stopped(Event):
    """STOPPED: everything stands until a person resumes; ``reason`` is for people."""

    reason: str = ""
