"""What messages of earlier versions leave out, derived from what they do state.

Until version 0.2.0 only a sentence for people stated whether a demonstration was being recorded, what was asked, and
how a recording ended. Those sentences are in the bags and can change no more: reading them here is reading an old
format. Nothing else does.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any

import numpy as np
from mbd_model.session import Awaited, Phase
from numpy.typing import NDArray

_RECORDING, _PICK_ASKED, _PLACE_ASKED = "I am watching", "What do I use now?", "Where do I go next?"
_ENDED_HOLDING = "the demonstration ended while holding "
_WAITING = {
    "waiting for the task": Awaited.TASK,
    "waiting for the target scene": Awaited.TARGET_SCENE,
    "waiting for the mapping": Awaited.ESTIMATE,
}


def _recording(state: Any) -> bool:
    """Whether a demonstration was being recorded, of a state with the fields phase and detail."""
    return bool(state.phase == Phase.DEMONSTRATE and state.detail.startswith(_RECORDING))


def _awaiting(state: Any) -> int:
    """What was awaited when the state was published, of one with the fields phase, paused and detail.

    UNKNOWN in EXECUTE: the state did not state whether a robot executed the task.
    """
    if state.phase in (Phase.DONE, Phase.ABORTED):
        return Awaited.NOTHING
    if state.paused:
        return Awaited.RESUME
    if state.phase == Phase.DEMONSTRATE:
        return Awaited.DEMONSTRATION_STOP if _recording(state) else Awaited.DEMONSTRATION_START
    if state.phase == Phase.ASSIST:
        asked = {_PICK_ASKED: Awaited.HANDED, _PLACE_ASKED: Awaited.POINTED}
        begins = (what for words, what in asked.items() if state.detail.startswith(words))
        return next(begins, _WAITING.get(state.detail, Awaited.ESTIMATE))
    return Awaited.UNKNOWN if state.phase == Phase.EXECUTE else Awaited.NEXT_PHASE


def _open_ends(task: Any) -> NDArray[np.uint32]:
    """Which problems only state how the recording ended, of a task with the field problems."""
    numbers = [number for number, problem in enumerate(task.problems) if problem.startswith(_ENDED_HOLDING)]
    return np.array(numbers, np.uint32)


# Until then perception did not state how exactly it measures: has_std is false.
# Before the robot asked "is that so?" it confirmed, denied and doubted nothing, and its questions named no target:
# ROS's defaults are what happened. The two readings of an estimate are empty, which states that it made none.
NEVER_YET = tuple(
    (f"mbd_msgs/msg/{kind}", field)
    for kind, fields in {
        "Assist": ("confirmed",),
        "Assists": ("denials",),
        "SessionState": ("denials", "skipped", "words", "verdict"),
        "Progress": ("failure",),
        "Prompt": ("target_ids", "source_ids"),
        "WizardReply": ("sequence", "heard"),
        "WizardNote": ("marker",),
        "ObjectFeatures": (
            *("has_std", "centroid_std", "box_center_std", "size_std"),
            *("yaw_std", "volume_std", "hue_std", "saturation_std"),
        ),
        "MappingEstimate": ("best_guess", "obeying", "doubted", "doubt", "question_kind", "question_targets"),
    }.items()
    for field in fields
)


def _doubts(task: Any) -> NDArray[np.float32]:
    """No doubt was recorded about the steps of an older version's task."""
    return np.zeros(len(task.steps), np.float32)


# Of (type, field): its value, from the fields the message had.
DERIVED: dict[tuple[str, str], Callable[[Any], Any]] = {
    ("mbd_msgs/msg/SessionState", "recording"): _recording,
    ("mbd_msgs/msg/SessionState", "awaiting"): _awaiting,
    ("mbd_msgs/msg/Task", "open_ends"): _open_ends,
    **{field: attrgetter(field[1]) for field in NEVER_YET},
    ("mbd_msgs/msg/Task", "doubts"): _doubts,
}
