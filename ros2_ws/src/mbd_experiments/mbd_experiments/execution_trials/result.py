"""What a trial is, and what became of it: values, and the files and rows they are kept in."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path

from mbd_cell.adversary import TableDisturbance
from mbd_cell.physics.grasp import Grasp
from mbd_model.errors import MbdError

from mbd_experiments.csv_table import CsvRow
from mbd_experiments.simulated_participants.error_model import Slip

TASKS = ("stacking", "sorting", "lunch_packing", "dish_sorting", "assembly")


class TrialHalf(StrEnum):
    """Object sets of even seeds may be looked at while the robot is being made, those of odd seeds only counted."""

    CHOOSE = "choose"
    REPORT = "report"

    @staticmethod
    def of(seed: int) -> TrialHalf:
        """That of a seed."""
        return TrialHalf.REPORT if seed % 2 else TrialHalf.CHOOSE


@dataclass(frozen=True)
class TrialCase:
    """One session to be tried.

    Attributes:
        task: its name.
        seed: of the object sets, layouts, the teacher's hand, the camera's noise and the adversary.
        grasp: what keeps things in the hand.
        disturbances: what the adversary does, once each.
        teacher_errors: of the teacher, those that may happen; whether they do is drawn.
        threshold: confidence from which the robot goes on alone; None for the strategy's own.
    """

    task: str
    seed: int
    grasp: Grasp = Grasp.WELD
    disturbances: tuple[TableDisturbance, ...] = ()
    teacher_errors: tuple[Slip, ...] = ()
    threshold: float | None = None

    @property
    def name(self) -> str:
        """Of its files."""
        return f"{self.task}_{self.seed:03}"

    @property
    def conditions(self) -> str:
        """All but task and seed: trials of one folder have them in common, but for whose turn it is to disturb."""
        alone = () if self.threshold is None else (f"alone from {self.threshold:g}",)
        return ", ".join((f"grasp {self.grasp}", *alone, *self.disturbances, *self.teacher_errors))


@dataclass(frozen=True)
class TrialResult:
    """What became of it.

    Attributes:
        task, seed, conditions: as in TrialCase.
        right: every object is where it should be and the robot reported the task done.
        places_right, places: place steps whose object is where it should be, and all.
        assists: how often the teacher answered, before the robot's work and during it.
        at_work: how often during it.
        disturbed: what the adversary did, in words.
        asked: what the robot asked about at work, by the failures' names.
        mended: objects he put right because the robot asked.
        errors: what the teacher got wrong, in words.
        dropped, unnoticed: objects that left the hand by themselves, and those of them the robot reported as placed.
        arm_table, arm_objects: contacts of the robot with the table, and with objects it did not handle just then.
        seconds: simulated time of the robot's work [s].
        wall: time it took here [s].
        why: one sentence about why it is not right; "" when it is.
    """

    task: str
    seed: int
    conditions: str
    right: bool
    places_right: int = 0
    places: int = 0
    assists: int = 0
    at_work: int = 0
    disturbed: str = ""
    asked: str = ""
    mended: str = ""
    errors: str = ""
    dropped: int = 0
    unnoticed: int = 0
    arm_table: int = 0
    arm_objects: int = 0
    seconds: float = 0.0
    wall: float = 0.0
    why: str = ""

    @property
    def sentence(self) -> str:
        """What became of it, for people."""
        if self.right:
            return f"{self.task} seed {self.seed}: right"
        after = f" after {self.disturbed}" if self.disturbed else ""
        return f"{self.task} seed {self.seed}{after}: {self.why or 'not right'}."

    @property
    def row(self) -> CsvRow:
        """Of the table of all trials."""
        return {**asdict(self), "right": int(self.right), "half": str(TrialHalf.of(self.seed))}


def write_result(path: Path, result: TrialResult) -> None:
    """Keep a result, complete or not at all, so that an interrupted run goes on where it stopped."""
    half_written = path.with_suffix(".part")
    half_written.write_text(json.dumps(asdict(result), indent=1), encoding="utf-8")
    half_written.replace(path)


def read_result(path: Path) -> TrialResult:
    """A kept result.

    Raises:
        MbdError: the file is none.
    """
    try:
        return TrialResult(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise MbdError(f"{path} is no result of a trial ({error}); remove it, and the trial is done again") from error


def cases(
    tasks: Sequence[str], seeds: Sequence[int], adversary: Sequence[TableDisturbance], each: bool, base: TrialCase
) -> tuple[TrialCase, ...]:
    """The trials of these tasks and seeds.

    Args:
        tasks: their names.
        seeds: of object sets and layouts.
        adversary: the disturbances there are; () for none.
        each: one of them a session, in turn over the seeds; else all of them in every session.
        base: gives the rest.
    """
    return tuple(
        replace(base, task=task, seed=seed, disturbances=_of_seed(adversary, seed) if each else tuple(adversary))
        for task in tasks
        for seed in seeds
    )


def _of_seed(adversary: Sequence[TableDisturbance], seed: int) -> tuple[TableDisturbance, ...]:
    # The halves of the seeds get every disturbance alike.
    return (adversary[(seed // 2) % len(adversary)],) if adversary else ()
