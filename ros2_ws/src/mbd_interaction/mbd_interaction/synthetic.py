"""Small sessions with known truth, and random events, for tests and examples."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, TypeVar

import numpy as np
from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.estimate import Mapping, MappingEstimate, QuestionKind
from mbd_model.execution_progress import Failure, Status
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.session import Awaited, Phase
from mbd_model.task import StepKind, Task, TaskStep

from mbd_interaction import events
from mbd_interaction.dialogue import Dialogue, Outcome
from mbd_interaction.effects import Call, Effect
from mbd_interaction.events import Event, Signal
from mbd_interaction.phases.questions import CLOSED
from mbd_interaction.transitions import transition

SECOND = 1_000_000_000
SIGNALS = tuple(s for s in Signal if s is not Signal.STOPPED)  # a stop would hold most of a random walk
Value = TypeVar("Value")


@cache
def row_of_objects(role: Role, prefix: str, n: int) -> Scene:
    """``n`` cups of 6 cm, 20 cm apart along y."""
    return Scene(
        role,
        tuple(SceneObject(f"{prefix}{k}", (0.5, 0.2 * k, 0.05), (0.06, 0.06, 0.1)) for k in range(1, n + 1)),
    )


@cache
def stacking_task(n: int) -> Task:
    """s1 onto s2, s3 onto s1, s4 onto s3 ...: each object but s2 is picked once and placed."""
    picks = [i for i in range(1, n + 1) if i != 2]
    onto = [2, *picks[:-1]]
    steps: list[TaskStep] = []
    for picked, receiver in zip(picks, onto, strict=True):
        for kind, primary in ((StepKind.PICK, picked), (StepKind.PLACE, receiver)):
            steps.append(TaskStep(len(steps), kind, f"s{primary}", 0.0))
    return Task(row_of_objects(Role.SOURCE, "s", n), tuple(steps))


def doubtful_task(n: int, *doubtful: int) -> Task:
    """The stacking task, of whose steps (0-based) those numbered are in doubt: their runner-up is another object."""
    task = stacking_task(n)
    others = [next(i for i in task.source.ids if i != s.primary_object) for s in task.steps]
    steps = [
        replace(s, end=float(k), runner_up=other, doubt=0.3 if k in doubtful else 0.0)
        for k, (s, other) in enumerate(zip(task.steps, others, strict=True))
    ]
    return replace(task, steps=tuple(steps))


def true_target(source_id: str) -> str:
    """The target object that plays a source object's part: t1 for s1 and so on."""
    return source_id.replace("s", "t", 1)


def obeying(dialogue: Dialogue) -> Mapping:
    """The true mapping of the objects used, but as the assists claim; of two that claim one object, the later."""
    told = {a.target_id: a.source_id for a in dialogue.assists}
    claimed = {source: target for target, source in told.items()}
    used = dialogue.task.used_objects if dialogue.task else ()
    free = [(s, true_target(s)) for s in used if s not in claimed and true_target(s) not in told]
    return Mapping((*claimed.items(), *free), 0.2)


def estimate_for(
    dialogue: Dialogue, at: int, confidence: float, threshold: float = 0.02, **fields: Any
) -> events.EstimateReceived:
    """What a mapping node that knows the truth, and obeys, would state of the dialogue's present inputs.

    Args:
        dialogue: whose inputs.
        at: when it comes [ns].
        confidence: of the mapping.
        threshold: from which on the robot would go on alone.
        fields: of the estimate, in place of those.
    """
    mapping = obeying(dialogue)
    assisted = {a.source_id for a in dialogue.assists}
    open_ids = [s for s in (dialogue.task.used_objects if dialogue.task else ()) if s not in assisted]
    next_question = open_ids[-1] if open_ids else ""
    estimate = MappingEstimate("evidence", mapping, confidence, next_question=next_question, obeying=mapping)
    return events.EstimateReceived(
        Signal.ESTIMATE,
        at,
        estimate=replace(estimate, **fields),
        sure=bool(mapping.pairs) and confidence >= threshold,
        task_stamp=dialogue.task_stamp,
        scene_stamp=dialogue.target_stamp,
        assists_stamp=dialogue.assists_stamp,
    )


def random_estimate(rng: np.random.Generator, dialogue: Dialogue, at: int) -> events.EstimateReceived:
    """An estimate that may doubt an assist, contradict some, or want to ask by naming objects, known or not."""
    fields: dict[str, Any] = {}
    targets = [*(dialogue.target.ids if dialogue.target else ()), "t99"]
    if dialogue.assists and rng.random() < 0.3:
        fields["doubted"] = dialogue.assists[int(rng.integers(len(dialogue.assists)))]
    if rng.random() < 0.3:
        sources = dialogue.task.used_objects if dialogue.task else ()
        mixed = [str(t) for t in rng.permutation(targets)]
        fields["obeying"] = Mapping(tuple(zip(sources, mixed, strict=False)), 0.1)
    if rng.random() < 0.5:
        kind = tuple(QuestionKind)[int(rng.integers(len(QuestionKind)))]
        count = CLOSED.get(kind, 0) if rng.random() < 0.8 else int(rng.integers(0, 3))
        fields["question_kind"] = kind
        fields["question_targets"] = tuple(str(t) for t in rng.permutation(targets)[:count])
    return estimate_for(dialogue, at, (0.0, 0.01, 0.3)[int(rng.integers(3))], **fields)


def results(dialogue: Dialogue, effects: tuple[Effect, ...], at: int, n: int) -> list[Event]:
    """What other nodes answer to the dialogue's requests when all goes well, with scenes of ``n`` objects."""
    answers: list[Event] = []
    for effect in effects:
        if isinstance(effect, Call) and effect.token is not None:
            scene = row_of_objects(Role.TARGET, "t", n) if dialogue.phase.name == "OBSERVE_TARGET" else None
            done = events.RequestDone(
                Signal.REQUEST_DONE, at, "", effect.token, True, "done", scene, at if scene else 0
            )
            answers.append(done)
            if effect.request.name == "STOP":
                answers.append(events.TaskReceived(Signal.TASK, at, task=stacking_task(n), stamp=at))
    return answers


SIGNAL_OF_AWAITED = {
    Awaited.NEXT_PHASE: Signal.NEXT_PHASE,
    Awaited.DEMONSTRATION_START: Signal.START,
    Awaited.DEMONSTRATION_STOP: Signal.STOP,
    Awaited.HANDED: Signal.HANDED,
    Awaited.POINTED: Signal.POINTED,
    Awaited.RESUME: Signal.RESUME,
    Awaited.CONFIRMATION: Signal.YES,
    Awaited.YES_OR_NO: Signal.YES,
    Awaited.HELP: Signal.YES,
}


def awaited_event(dialogue: Dialogue, at: int, n: int, confidence: float = 0.0) -> Event | None:
    """What the dialogue awaits, as it comes when all goes well; None when nothing does, or no object is left to give.

    Args:
        dialogue: that awaits it.
        at: when it comes [ns].
        n: objects of a scene or task that comes.
        confidence: of an estimate that comes.
    """
    awaiting, signal = dialogue.awaiting, SIGNAL_OF_AWAITED.get(dialogue.awaiting)
    if awaiting is Awaited.ONE_OF_TWO:
        return Event(Signal.NO, at, "wizard/answer")
    if signal in (Signal.HANDED, Signal.POINTED):
        last = dialogue.assists[-1].target_id if dialogue.assists else ""
        free = [i for i in (dialogue.target.ids if dialogue.target else ()) if i != last]
        return events.Answered(signal, at, f"wizard/{signal}", free[0]) if free else None
    if signal is not None:
        return Event(signal, at, "wizard/command")
    scene = row_of_objects(Role.TARGET, "t", n)
    done = events.RequestDone(Signal.REQUEST_DONE, at, "", dialogue.token, True, "done", scene, at)
    stamps = dialogue.assists_stamp
    return {
        Awaited.OBSERVATION: done,
        Awaited.RECORDING: done,
        Awaited.TASK: events.TaskReceived(Signal.TASK, at, task=stacking_task(n), stamp=at),
        Awaited.TARGET_SCENE: events.TargetReceived(Signal.TARGET, at, scene=scene, stamp=at),
        Awaited.ESTIMATE: estimate_for(dialogue, at, confidence),
        Awaited.EXECUTION: events.ProgressReceived(Signal.PROGRESS, at, "", -1, Status.FINISHED, "done", stamps),
    }.get(awaiting)


def random_walk(
    rng: np.random.Generator, n_events: int, start: Dialogue, n: int = 5, led: float = 0.0
) -> Iterator[tuple[Dialogue, Event, Outcome]]:
    """(dialogue before, event, what it does) of a dialogue fed with random events; after an abort a new one begins.

    Its requests are often answered as they should be, over scenes of ``n`` objects; a second passes between events.
    Of ``led`` of the events, 0..1, each is what the dialogue awaits.
    """
    dialogue, at = start, SECOND
    waiting: list[Event] = []
    for _ in range(n_events):
        at += SECOND
        event = waiting.pop(0) if waiting and rng.random() < 0.8 else random_event(rng, dialogue, at, n)
        if led and rng.random() < led:
            event = awaited_event(dialogue, at, n) or event
            if dialogue.awaiting is Awaited.ESTIMATE and rng.random() < 0.5:
                event = random_estimate(rng, dialogue, at)
        if event.signal is Signal.ABORT and rng.random() < 0.9:
            continue
        outcome = transition(dialogue, event)
        yield dialogue, event, outcome
        waiting += results(dialogue, outcome.effects, at, n)
        dialogue = outcome.dialogue
        if dialogue.phase is Phase.ABORTED:
            dialogue = Dialogue("again", config=start.config)


def random_event(rng: np.random.Generator, dialogue: Dialogue, at: int, n: int, signal: Signal | None = None) -> Event:
    """Any event at all: of any kind or of that given, of known and unknown objects, early and late, good and broken."""

    def one_of(values: Sequence[Value]) -> Value:
        return values[int(rng.integers(len(values)))]

    signal = one_of(SIGNALS) if signal is None else signal
    object_id = one_of([*(f"t{k}" for k in range(1, n + 1)), "", "t99", "<b>", "s1"])
    stamp = one_of([dialogue.assists_stamp, dialogue.target_stamp, dialogue.task_stamp, at])
    late = at - int(rng.integers(0, 10)) * SECOND
    if signal in (Signal.HANDED, Signal.POINTED):
        x, y, z = (one_of([0.0, 0.2, 0.5, math.nan, math.inf, -3.0]) for _ in range(3))
        return events.Answered(signal, late, "wizard/any", object_id, (x, y, z))
    if signal is Signal.OVERWRITE:
        return events.Overwritten(signal, at, "wizard/overwrite", int(rng.integers(-1, 12)), object_id)
    if signal is Signal.GRIPPER:
        return events.Gripped(signal, at, "wizard/gripper", bool(rng.integers(2)))
    if signal is Signal.UNREADABLE:
        return events.Unreadable(signal, at, "wizard/command", "command 99 is unknown")
    if signal is Signal.REQUEST_DONE:
        scene = row_of_objects(Role.TARGET, "t", int(rng.integers(1, n + 1))) if rng.random() < 0.5 else None
        token = dialogue.token - int(rng.integers(0, 2))
        return events.RequestDone(signal, at, "", token, bool(rng.random() < 0.7), "so it went", scene, stamp)
    if signal is Signal.REVISE:
        kind = CorrectionKind(int(rng.integers(1, 7)))
        correction = StepCorrection(kind, int(rng.integers(0, 12)), int(rng.integers(0, 12)), object_id, float(late))
        return events.Revised(signal, at, "wizard/revision", correction)
    if signal is Signal.TASK:
        task = doubtful_task(int(rng.integers(2, n + 1)), *(int(k) for k in rng.integers(0, 20, size=3)))
        return events.TaskReceived(signal, at, task=task, stamp=stamp)
    if signal is Signal.TARGET:
        scene = row_of_objects(Role.TARGET, "t", int(rng.integers(1, n + 1)))
        return events.TargetReceived(signal, at, scene=scene, stamp=stamp)
    if signal is Signal.ESTIMATE:
        return random_estimate(rng, dialogue, at)
    if signal is Signal.STOPPED:
        return events.Stopped(signal, at, reason="emergency stop")
    if signal is Signal.PROGRESS:
        status = Status(int(rng.integers(1, 7)))
        step = int(rng.integers(-1, 12))
        failure = Failure(int(rng.integers(12))) if status is Status.FAILED else Failure.NONE
        return events.ProgressReceived(signal, at, "", step, status, "so far", stamp, failure)
    return Event(signal, at, "wizard/command")
