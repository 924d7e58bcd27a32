"""One task executed in the simulated cell with the right mapping given, and what became of each place step."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.layout.scenes import TaskScenes
from mbd_cell.outcome import PlaceOutcome, outcomes
from mbd_execution.execution import begin, progress
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.parallel.executor import Executor
from mbd_model.times import to_seconds
from mbd_perception.features.measure import ObserveConfig

from mbd_experiments.execution_trials.simulated_session import execute, object_states, right_mapping, show
from mbd_experiments.perceiving import cell_perception


@dataclass(frozen=True)
class Trial:
    """One task executed once.

    Attributes:
        task: its name.
        seed: of layouts, teacher and camera.
        places: what became of each place step.
        ending: what the robot reported at the end.
        seconds: simulated time it took.
    """

    task: str
    seed: int
    places: tuple[PlaceOutcome, ...]
    ending: str
    seconds: float

    @property
    def success(self) -> bool:
        """Every object is where it should be."""
        return bool(self.places) and all(p.success for p in self.places)


@dataclass(frozen=True)
class NotShown:
    """A trial that did not come to the robot's work: of which task and seed, and why."""

    task: str
    seed: int
    reason: str


def run_trials(
    which: Sequence[tuple[str, int]], executor: Executor, cell_config: Path, knowledge: Path
) -> Iterator[tuple[Trial | NotShown, float]]:
    """Each trial in its turn, and the seconds it took here.

    Args:
        which: tasks and seeds.
        executor: who runs them; the workers of a cluster see both files under the same paths.
        cell_config: folder of the cell's configuration.
        knowledge: perception's knowledge base.
    """
    run = partial(_tried, cell_config.absolute(), knowledge.absolute())
    return executor.run_all(run, which, lambda item: f"{item[0]} seed {item[1]}")


def _tried(cell_config: Path, knowledge: Path, which: tuple[str, int]) -> tuple[Trial | NotShown, float]:
    task, seed = which
    started = time.monotonic()
    result: Trial | NotShown
    try:
        scenes = load_scenes(cell_config / f"{task}.yaml")
        result = run_trial(scenes, seed, cell_perception(cell_config, knowledge))
    except MbdError as error:
        result = NotShown(task, seed, str(error))
    return result, time.monotonic() - started


def run_trial(scenes: TaskScenes, seed: int, perception: ObserveConfig) -> Trial:
    """Show a task in the cell, give the right mapping, execute the task, and look where things are."""
    shown = show(scenes, seed, perception)
    mapping = right_mapping(shown)
    begun = shown.cell.time_ns
    work = execute(begin(plan(shown.task, shown.target, mapping), HandConfig()), shown.cell)
    took = to_seconds(shown.cell.time_ns - begun)
    for _ in range(100):
        shown.cell.tick()
    names = shown.names
    true_mapping = {
        names[Role.SOURCE][s]: names[Role.TARGET][t] for s, t in mapping.items() if t in names[Role.TARGET]
    }  # fmt: skip
    places = outcomes(scenes.steps, shown.left, object_states(shown.cell), true_mapping)
    return Trial(scenes.task, seed, places, progress(work).text, took)
