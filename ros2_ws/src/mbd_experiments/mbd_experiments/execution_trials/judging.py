"""Whether a session ended right: by true poses only, against what was demonstrated."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mbd_cell.layout.scenes import DemonstratedStep, TaskScenes
from mbd_cell.outcome import ObjectState, PlaceOutcome, outcomes
from mbd_model.task import StepKind


@dataclass(frozen=True)
class TaskVerdict:
    """The best of the right mappings as executed.

    Attributes:
        places: what became of the last place of each object.
        mapping: source name -> target name it was judged by.
    """

    places: tuple[PlaceOutcome, ...]
    mapping: Mapping[str, str]

    @property
    def right(self) -> bool:
        """Every object is where it should be."""
        return bool(self.places) and all(p.success for p in self.places)

    @property
    def wrong(self) -> str:
        """Which are not, and why."""
        return "; ".join(
            f"{p.held or 'an object'}{f' onto {p.onto}' if p.onto else ''}: {p.why}"
            for p in self.places
            if not p.success
        )


def judge(scenes: TaskScenes, left: Mapping[str, ObjectState], now: Mapping[str, ObjectState]) -> TaskVerdict:
    """What became of the task: every right mapping is tried, the one that fits best is judged by.

    Args:
        scenes: with the steps as they were demonstrated.
        left: the source objects as the demonstration left them.
        now: the target objects after the robot's work.
    """
    last = last_places(scenes.steps)
    verdicts = (
        TaskVerdict(tuple(p for p in outcomes(scenes.steps, left, now, mapping) if p.step in last), mapping)
        for mapping in right_mappings(scenes)
    )
    return max(verdicts, key=lambda verdict: sum(p.success for p in verdict.places))


def last_places(steps: Sequence[DemonstratedStep]) -> frozenset[int]:
    """Indices of the place steps that are the last of their object: earlier ones only put it aside."""
    last = {step.picked: index for index, step in enumerate(steps) if step.kind is StepKind.PLACE}
    return frozenset(last.values())


def right_mappings(scenes: TaskScenes) -> Iterator[Mapping[str, str]]:
    """Every mapping of the objects of the steps that the solution allows, each target used once."""
    names = [n for n in scenes.solution if any(n in (s.picked, s.onto) for s in scenes.steps)]
    for targets in itertools.product(*(scenes.solution[n] for n in names)):
        if len(set(targets)) == len(targets):
            yield dict(zip(names, targets, strict=True))
