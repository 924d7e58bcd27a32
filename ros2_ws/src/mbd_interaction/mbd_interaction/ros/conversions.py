"""From wizard and result messages to the dialogue's events."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mbd_model.execution_progress import Failure, Status
from mbd_model.ros.conversions import (
    correction_from_msg,
    estimate_from_msg,
    inputs_from_msg,
    scene_from_msg,
    stamp_from_msg,
    task_from_msg,
)
from mbd_msgs import msg as m

from mbd_interaction import events
from mbd_interaction.events import Event, Signal

Coded = m.WizardCommand | m.WizardDemonstration

COMMANDS = {
    m.WizardCommand.NEXT_PHASE: Signal.NEXT_PHASE,
    m.WizardCommand.UNDO: Signal.UNDO,
    m.WizardCommand.SKIP: Signal.SKIP,
    m.WizardCommand.PAUSE: Signal.PAUSE,
    m.WizardCommand.RESUME: Signal.RESUME,
    m.WizardCommand.ABORT: Signal.ABORT,
    m.WizardCommand.BACK: Signal.BACK,
    m.WizardCommand.REDO: Signal.REDO,
}
DEMONSTRATION = {m.WizardDemonstration.START: Signal.START, m.WizardDemonstration.STOP: Signal.STOP}


ANSWERS = {m.WizardAnswer.YES: Signal.YES, m.WizardAnswer.NO: Signal.NO}


def _coded(codes: dict[int, Signal], names: str) -> Callable[[Coded, int, str], Event]:
    def event(msg: Coded, at: int, topic: str) -> Event:
        if msg.command in codes:
            return Event(codes[msg.command], at, topic)
        reason = f"command {msg.command} is unknown: expected {names}"
        return events.Unreadable(Signal.UNREADABLE, at, topic, reason)

    return event


def _gripped(msg: m.WizardGripper, at: int, topic: str) -> Event:
    if msg.command in (m.WizardGripper.OPEN, m.WizardGripper.CLOSE):
        return events.Gripped(Signal.GRIPPER, at, topic, msg.command == m.WizardGripper.CLOSE)
    reason = f"command {msg.command} is unknown: expected OPEN (1) or CLOSE (2)"
    return events.Unreadable(Signal.UNREADABLE, at, topic, reason)


def _handed(msg: m.WizardHanded, at: int, topic: str) -> Event:
    return events.Answered(Signal.HANDED, at, topic, msg.object_id)


def _pointed(msg: m.WizardPointed, at: int, topic: str) -> Event:
    return events.Answered(Signal.POINTED, at, topic, msg.object_id, (msg.place.x, msg.place.y, msg.place.z))


def _yes_or_no(msg: m.WizardAnswer, at: int, topic: str) -> Event:
    if msg.answer in ANSWERS:
        return Event(ANSWERS[msg.answer], at, topic)
    reason = f"answer {msg.answer} is unknown: expected YES (1) or NO (2)"
    return events.Unreadable(Signal.UNREADABLE, at, topic, reason)


def _overwritten(msg: m.WizardOverwrite, at: int, topic: str) -> Event:
    return events.Overwritten(Signal.OVERWRITE, at, topic, int(msg.step_index), msg.object_id)


def _revised(msg: m.WizardRevision, at: int, topic: str) -> Event:
    try:
        return events.Revised(Signal.REVISE, at, topic, correction_from_msg(msg))
    except ValueError as error:  # MbdError is one
        return events.Unreadable(Signal.UNREADABLE, at, topic, str(error))


def _noted(_msg: m.WizardNote, at: int, topic: str) -> Event:
    return Event(Signal.NOTE, at, topic)


# Each wizard topic: its message, and what that states.
WIZARD_TOPICS: dict[str, tuple[type, Callable[[Any, int, str], Event]]] = {
    "wizard/gripper": (m.WizardGripper, _gripped),
    "wizard/handed": (m.WizardHanded, _handed),
    "wizard/pointed": (m.WizardPointed, _pointed),
    "wizard/answer": (m.WizardAnswer, _yes_or_no),
    "wizard/demonstration": (m.WizardDemonstration, _coded(DEMONSTRATION, "START (1) or STOP (2)")),
    "wizard/command": (m.WizardCommand, _coded(COMMANDS, "NEXT_PHASE (1) to REDO (8), see WizardCommand.msg")),
    "wizard/overwrite": (m.WizardOverwrite, _overwritten),
    "wizard/revision": (m.WizardRevision, _revised),
    "wizard/note": (m.WizardNote, _noted),
}


def task_received(msg: m.Task, at: int) -> Event:
    """The latched task; raises MbdError or ValueError when it holds what cannot be."""
    return events.TaskReceived(Signal.TASK, at, task=task_from_msg(msg), stamp=stamp_from_msg(msg.header.stamp))


def target_received(msg: m.Scene, at: int) -> Event:
    """The latched target scene; raises MbdError or ValueError when it holds what cannot be."""
    return events.TargetReceived(Signal.TARGET, at, scene=scene_from_msg(msg), stamp=stamp_from_msg(msg.header.stamp))


def estimate_received(msg: m.MappingEstimate, at: int) -> Event:
    """The latched estimate; raises MbdError or ValueError when it holds what cannot be."""
    estimate, inputs = estimate_from_msg(msg), inputs_from_msg(msg)
    return events.EstimateReceived(
        Signal.ESTIMATE,
        at,
        estimate=estimate,
        sure=bool(estimate.executed.pairs) and estimate.ties <= 1 and estimate.confidence >= inputs.threshold,
        task_stamp=inputs.task_stamp,
        scene_stamp=inputs.scene_stamp,
        assists_stamp=inputs.assists_stamp,
    )


def progress_received(msg: m.Progress, at: int) -> Event:
    """The latched progress; raises ValueError for a status or a failure there is not."""
    return events.ProgressReceived(
        Signal.PROGRESS,
        at,
        step_index=int(msg.step_index),
        status=Status(msg.status),
        text=msg.text,
        assists_stamp=stamp_from_msg(msg.assists_stamp),
        failure=Failure(msg.failure),
    )
