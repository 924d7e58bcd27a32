"""What a demonstration is once it is understood: an ordered list of pick and place steps (paper sec. 4.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from mbd_model.errors import MbdError
from mbd_model.objects import Scene


class StepKind(IntEnum):
    """What the gripper did at the end of the step; values equal mbd_msgs/TaskStep."""

    PICK = 1
    PLACE = 2


@dataclass(frozen=True)
class TaskStep:
    """One step of the demonstrated task.

    Attributes:
        index: 0-based place in the task.
        kind: PICK (the gripper closed) or PLACE (it opened).
        primary_object: id of the source object closest to the gripper at the end of the step.
        distance: from the tool to that object at that time [m].
        runner_up: id of the next closest object, "" when there is none.
        runner_up_distance: its distance [m], inf when there is none.
        start, end: times of the step [s].
        tool_position: (x, y, z) of the tool at ``end`` [m, robot base frame].
        tool_quaternion: (x, y, z, w) of the tool at ``end``.
        offset: tool_position minus the primary object's centroid at that time [m].
        doubt: probability that the runner-up was meant, 0..0.5: both are about as near, or as well put onto.
    """

    index: int
    kind: StepKind
    primary_object: str
    distance: float
    runner_up: str = ""
    runner_up_distance: float = math.inf
    start: float = 0.0
    end: float = 0.0
    tool_position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tool_quaternion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    doubt: float = 0.0


@dataclass(frozen=True)
class Task:
    """A demonstrated task: its steps over its source scene.

    Attributes:
        source: the scene it was demonstrated in.
        steps: in order.
        problems: what the recording holds that is no step, one sentence each.
        stamp: time at which the task was complete [s].
        open_ends: which problems (0-based) only state how it ended, as with an object held: gone once it goes on.
    """

    source: Scene
    steps: tuple[TaskStep, ...]
    problems: tuple[str, ...] = ()
    stamp: float = 0.0
    open_ends: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        """Validate once; raises MbdError for a step on an object the source scene does not have."""
        for step in self.steps:
            if step.primary_object not in self.source.ids:
                raise MbdError(
                    f"step {step.index} names '{step.primary_object}', which the source scene does not have: "
                    f"it has {sorted(self.source.ids)}"
                )

    @property
    def used_objects(self) -> tuple[str, ...]:
        """Source objects the steps name, each once, in the order first named."""
        return tuple(dict.fromkeys(step.primary_object for step in self.steps))
