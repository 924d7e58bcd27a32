"""A recording that was cut off by the end of its node: what nobody saw meanwhile, and whether it matters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.task import StepKind, Task
from numpy.typing import NDArray

from mbd_demonstration.gripper import GripperAction, GripperEvent

ACTION_OF = {StepKind.PICK: GripperAction.CLOSE, StepKind.PLACE: GripperAction.OPEN}
SAME = 0.25  # [s] between two stamps of one command that came by two ways


def gaps(cuts: Sequence[float], stamps: NDArray[np.float64]) -> list[tuple[float, float]]:
    """From when to when [s] nobody saw the tool.

    Args:
        cuts: the last tool pose before each end of a node [s].
        stamps: (n,) of all tool poses [s].
    """
    found = []
    for cut in cuts:
        later = stamps[stamps > cut]
        found.append((cut, float(later.min()) if later.size else np.inf))
    return found


def received_before(events: Sequence[GripperEvent], event: GripperEvent) -> bool:
    """Whether the command is among the events, by whatever way it came."""
    return any(e.action is event.action and abs(e.stamp - event.stamp) <= SAME for e in events)


def cut_off_notes(
    task: Task, begin: float, unseen: Sequence[tuple[float, float]], events: Sequence[GripperEvent]
) -> tuple[str, ...]:
    """A sentence about each gap, in which the gripper did nothing.

    Args:
        task: as recorded.
        begin: of the recording [s].
        unseen: gaps [s].
        events: gripper commands that were passed on.

    Raises:
        MbdError: the gripper acted where nobody saw the tool, so that this has to be shown again.
    """
    notes = []
    for start, end in unseen:
        when = f"from {start - begin:.1f} s to {end - begin:.1f} s" if end < np.inf else f"at {start - begin:.1f} s"
        acted = [e.action for e in events if start < e.stamp < end]
        acted += [ACTION_OF[s.kind] for s in task.steps if start < s.end < end]
        if acted:
            did = "closed" if acted[0] is GripperAction.CLOSE else "opened"
            raise MbdError(
                f"the recording was cut off {when}, and the hand {did} meanwhile, where nobody saw it: lay the objects "
                "as they were and show the task again"
            )
        notes.append(f"the recording was cut off {when}; the gripper did nothing meanwhile")
    return tuple(notes)
