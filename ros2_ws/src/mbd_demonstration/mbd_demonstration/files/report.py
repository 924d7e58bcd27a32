"""``demonstration_report FOLDER...``: how well the events and steps of recordings are read, a line for each.

A folder holds ``traj.csv`` and maybe ``meta.json`` (gripper_events: what its collector found and roughly when),
``scene.yaml`` (source objects) and ``steps.txt`` (the right steps, as ``PICK a; PLACE b``).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mbd_model.errors import MbdError

from mbd_demonstration.files.plateaus import held_levels
from mbd_demonstration.files.recording_formats import read_any
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper
from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.recording import in_tool_time, understood
from mbd_demonstration.recording_files import RecordedColumns, RecordingFileError, read_scene
from mbd_demonstration.trajectory import ToolTrajectory

UNUSABLE = 2
# An event farther than this from every one of its kind in the check is another one [s].
SAME = 2.0
HEAD = f"{'source':<28} {'rate':>6} {'events':>6} {'false':>5} {'missed':>6} {'mean':>6} {'most':>6}  steps right"


@dataclass(frozen=True)
class Line:
    """What one recording came to.

    Attributes:
        source: name of its folder.
        rate: median sampling rate [Hz].
        events: how many were found.
        false, missed: of those found, and of the check's; None where there is no check.
        off: (k,) [s] how far the others are from the plateaus of the raw width.
        steps: (right, of how many); None where the right ones are not known.
    """

    source: str
    rate: float
    events: int
    false: int | None = None
    missed: int | None = None
    off: tuple[float, ...] = ()
    steps: tuple[int, int] | None = None

    def __str__(self) -> str:
        """The line as it is printed."""
        count = [str(n) if n is not None else "-" for n in (self.false, self.missed)]
        off = [f"{value:.3f}" for value in (np.mean(self.off), max(self.off))] if self.off else ["-", "-"]
        steps = f"{self.steps[0]} of {self.steps[1]}" if self.steps else "-"
        return (
            f"{self.source:<28} {self.rate:>6.1f} {self.events:>6} {count[0]:>5} {count[1]:>6} {off[0]:>6} {off[1]:>6}"
            f"  {steps}"
        )


def line_of(folder: Path, polarity: Polarity) -> Line:
    """Read one folder.

    Raises:
        MbdError: its recording cannot be read.
    """
    columns = read_any(folder / "traj.csv")
    reading = read_gripper(columns.stamps, columns.gripper, FingerJointConfig(polarity=polarity))
    rate = 1.0 / reading.spacing if reading.spacing > 0.0 else 0.0
    line = Line(folder.name, rate, len(reading.events))
    meta = folder / "meta.json"
    if meta.is_file():
        line = _against(line, reading.events, columns, polarity, _rough(meta))
    if (folder / "scene.yaml").is_file() and (folder / "steps.txt").is_file():
        path = ToolTrajectory.from_samples(columns.stamps, columns.positions, columns.quaternions)
        moved, notes = in_tool_time(reading, path)
        task = understood(path, moved, read_scene(folder / "scene.yaml"), stamp=0.0, notes=notes)
        right = [words.strip() for words in (folder / "steps.txt").read_text(encoding="utf-8").split(";")]
        found = [f"{s.kind.name} {s.primary_object}" for s in task.steps]
        same = sum(a == b for a, b in zip(found, right, strict=False))
        line = Line(line.source, line.rate, line.events, line.false, line.missed, line.off, (same, len(right)))
    return line


def _rough(meta: Path) -> list[tuple[str, float]]:
    try:
        events = json.loads(meta.read_text(encoding="utf-8"))["gripper_events"]["events"]
        return [(str(e["type"]), float(e["t_s"])) for e in events]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise RecordingFileError(
            f"cannot read the events of {meta}: {error!r}; expected gripper_events: events: a list of type and t_s"
        ) from error


def _against(
    line: Line,
    events: Sequence[GripperEvent],
    columns: RecordedColumns,
    polarity: Polarity,
    rough: list[tuple[str, float]],
) -> Line:
    """The line with the events held against the plateaus of the raw width."""
    width = columns.gripper if polarity is Polarity.LARGER_OPEN else -columns.gripper
    order = np.argsort(columns.stamps, kind="stable")
    usable = order[np.isfinite(width[order]) & np.isfinite(columns.stamps[order])]
    expected = held_levels(columns.stamps[usable], width[usable], rough)
    left = list(events)
    off = []
    for kind, at in expected:
        same = [e for e in left if e.action.name.lower() == kind and abs(e.stamp - at) <= SAME]
        if same:
            nearest = same[int(np.argmin([abs(e.stamp - at) for e in same]))]
            left.remove(nearest)
            off.append(abs(nearest.stamp - at))
    return Line(line.source, line.rate, line.events, len(left), len(expected) - len(off), tuple(off), line.steps)


def run(words: Sequence[str] | None = None) -> str:
    """The table that the tool prints.

    Raises:
        MbdError: a folder that cannot be used.
    """
    parser = argparse.ArgumentParser(prog="demonstration_report", description="Print how well recordings are read.")
    parser.add_argument("folders", nargs="+", type=Path, help="each with traj.csv, or folders of such")
    parser.add_argument("--polarity", type=Polarity, choices=list(Polarity), default=Polarity.LARGER_OPEN)
    options = parser.parse_args(words)
    found = sorted(p.parent for folder in options.folders for p in folder.glob("**/traj.csv"))
    if not found:
        raise RecordingFileError(f"no traj.csv in {', '.join(map(str, options.folders))}")
    lines = [line_of(folder, options.polarity) for folder in found]
    return "\n".join([HEAD, *map(str, lines)])


def main() -> None:
    """Print, or report why not and end with 2."""
    try:
        sys.stdout.write(run() + "\n")
    except MbdError as error:
        sys.stderr.write(f"demonstration_report: {error}\n")
        sys.exit(UNUSABLE)
