"""One task carried out in the simulated cell with the right mapping given, and what became of each place step."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mbd_cell.layout.scenes import TaskScenes
from mbd_cell.outcome import PlaceOutcome, outcomes
from mbd_execution.execution import begin, progress
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_model.objects import Role

from mbd_experiments.execution_trials.simulated_session import carry_out, right_mapping, show, standing_objects


@dataclass(frozen=True)
class Trial:
    """One task carried out once.

    Attributes:
        seed: of layouts, teacher and camera.
        places: what became of each place step.
        said: what the robot said at the end.
        seconds: simulated time it took.
    """

    seed: int
    places: tuple[PlaceOutcome, ...]
    said: str
    seconds: float

    @property
    def success(self) -> bool:
        """Every object is where it should be."""
        return bool(self.places) and all(p.success for p in self.places)


def run_trial(scenes: TaskScenes, seed: int, knowledge: Path) -> Trial:
    """Show a task in the cell, give the right mapping, carry the task out, and look where things are."""
    shown = show(scenes, seed, knowledge)
    mapping = right_mapping(shown)
    begun = shown.cell.time_ns
    work = carry_out(begin(plan(shown.task, shown.target, mapping), HandConfig()), shown.cell)
    took = (shown.cell.time_ns - begun) / 1e9
    for _ in range(100):
        shown.cell.tick()
    names = shown.names
    true_mapping = {
        names[Role.SOURCE][s]: names[Role.TARGET][t] for s, t in mapping.items() if t in names[Role.TARGET]
    }  # fmt: skip
    places = outcomes(scenes.steps, shown.left, standing_objects(shown.cell), true_mapping)
    return Trial(seed, places, progress(work).text, took)
