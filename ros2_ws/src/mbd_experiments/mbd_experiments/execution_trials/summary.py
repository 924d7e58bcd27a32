"""Trials counted: shares with Wilson's intervals, what they cost, and what went wrong on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from scipy.stats import binomtest

from mbd_experiments.csv_table import CsvRow
from mbd_experiments.execution_trials.result import TrialHalf, TrialResult

CONFIDENCE = 0.95


@dataclass(frozen=True)
class RightShare:
    """How many of how many, with the interval [low, high] the true share lies in with 95 % (Wilson)."""

    hits: int
    of: int

    @property
    def interval(self) -> tuple[float, float]:
        """(low, high), each 0..1; of nothing: (0, 1)."""
        if self.of == 0:
            return 0.0, 1.0
        found = binomtest(self.hits, self.of).proportion_ci(CONFIDENCE, method="wilson")
        return float(found.low), float(found.high)

    @property
    def words(self) -> str:
        """For a table."""
        low, high = self.interval
        share = f"{100 * self.hits / self.of:.0f} %" if self.of else "-"
        return f"{self.hits} of {self.of}: {share} [{100 * low:.0f}, {100 * high:.0f}]"


@dataclass(frozen=True)
class TrialSummary:
    """Some trials together.

    Attributes:
        name: what they have in common.
        right: right to the last object.
        assists: mean number of the teacher's answers a session, before and during the robot's work.
        at_work: during it.
        dropped, unnoticed: objects.
        arm_table, arm_objects: contacts.
        seconds: mean simulated time of the robot's work [s].
        wall: mean time a trial took here [s].
    """

    name: str
    right: RightShare
    assists: float
    at_work: float
    dropped: int
    unnoticed: int
    arm_table: int
    arm_objects: int
    seconds: float
    wall: float

    @property
    def row(self) -> CsvRow:
        """Of the table of summaries."""
        low, high = self.right.interval
        return {
            "trials": self.name,
            "right": self.right.hits,
            "of": self.right.of,
            "low": low,
            "high": high,
            "assists": self.assists,
            "assists_at_work": self.at_work,
            "dropped": self.dropped,
            "dropped_unnoticed": self.unnoticed,
            "arm_table": self.arm_table,
            "arm_objects": self.arm_objects,
            "robot_seconds": self.seconds,
            "wall_seconds": self.wall,
        }


def summary(name: str, results: Sequence[TrialResult]) -> TrialSummary:
    """These trials together."""
    worked = [r for r in results if r.seconds > 0]
    return TrialSummary(
        name,
        RightShare(sum(r.right for r in results), len(results)),
        _mean([r.assists for r in results]),
        _mean([r.at_work for r in results]),
        sum(r.dropped for r in results),
        sum(r.unnoticed for r in results),
        sum(r.arm_table for r in results),
        sum(r.arm_objects for r in results),
        _mean([r.seconds for r in worked]),
        _mean([r.wall for r in results]),
    )


def summaries(results: Sequence[TrialResult]) -> tuple[TrialSummary, ...]:
    """By task, by half, by what the adversary did, and all; groups of which there is no trial are left out."""
    groups = {task: [r for r in results if r.task == task] for task in dict.fromkeys(r.task for r in results)}
    groups |= {f"half {half}": [r for r in results if TrialHalf.of(r.seed) is half] for half in TrialHalf}
    groups |= {words: [r for r in results if words in r.disturbed] for words in ACTS}
    if any(r.disturbed for r in results):
        groups["undisturbed"] = [r for r in results if not r.disturbed]
    return (*(summary(name, some) for name, some in groups.items() if some), summary("all", results))


# As an adversary's doings are described in results.
ACTS = ("pushed", "changed places", "taken away", "added", "knocked over", "lied")


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else 0.0
