"""``demonstration_report PATH...``: how well the events and steps of recordings are read, a line for each.

A path is a recording of any layout that ``steps`` reads, each episode of it a line, or a folder with ``traj.csv`` and
maybe ``meta.json`` (gripper_events: what its collector found and roughly when), ``scene.yaml`` (source objects) and
``steps.txt`` (the right steps, as ``PICK a; PLACE b``). Without ``meta.json`` the events to be found are read off the
raw opening by ``plateaus.acts``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero
from mbd_model.errors import MbdError

from mbd_demonstration.files.bounded_reading import read_bounded
from mbd_demonstration.files.plateaus import acts, held_stretches
from mbd_demonstration.files.recording_formats import ROBOMIMIC_RATE, Selection, episodes_of, read_any
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper
from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.recording_files import RecordedColumns, RecordingFileError, read_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_demonstration.understanding import in_tool_time, understood

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
        off: (k,) [s] how far the others are from the plateaus of the raw width (outside, where it gives way).
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


def line_of(path: Path, polarity: Polarity, selection: Selection | None = None) -> Line:
    """Read one recording: a folder as above, or (an episode of) a file.

    Raises:
        MbdError: it cannot be read.
    """
    folder = path if (path / "traj.csv").is_file() else None
    selection = selection or Selection()
    columns = read_bounded(read_any, folder / "traj.csv" if folder else path, selection)
    reading = read_gripper(columns.stamps, columns.gripper, FingerJointConfig(polarity=polarity))
    rate = 1.0 / reading.spacing if reading.spacing > 0.0 else 0.0
    name = folder.name if folder else f"{path.stem} {selection.episode}"
    meta = folder / "meta.json" if folder else None
    rough = _rough(meta) if meta and meta.is_file() else None
    line = _against(Line(name, rate, len(reading.events)), reading.events, columns, polarity, rough)
    if folder and (folder / "scene.yaml").is_file() and (folder / "steps.txt").is_file():
        tool = ToolTrajectory.from_samples(columns.stamps, columns.positions, columns.quaternions)
        moved, notes = in_tool_time(reading, tool)
        task = understood(tool, moved, read_bounded(read_scene, folder / "scene.yaml"), stamp=0.0, notes=notes)
        right = [words.strip() for words in (folder / "steps.txt").read_text(encoding="utf-8").split(";")]
        found = [f"{s.kind.name} {s.primary_object}" for s in task.steps]
        same = sum(a == b for a, b in zip(found, right, strict=False))
        line = replace(line, steps=(same, max(len(right), len(found))))
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
    rough: list[tuple[str, float]] | None,
) -> Line:
    """The line with the events held against the plateaus of the raw width."""
    width = columns.gripper if polarity is Polarity.LARGER_OPEN else -columns.gripper
    order = np.argsort(columns.stamps, kind="stable")
    usable = order[np.isfinite(width[order]) & np.isfinite(columns.stamps[order])]
    stamps, raw = columns.stamps[usable], width[usable]
    expected = held_stretches(stamps, raw, acts(stamps, raw) if rough is None else rough)
    left = list(events)
    off = []
    for held in expected:
        same = [e for e in left if e.action.name.lower() == held.kind and held.off(e.stamp) <= SAME]
        if same:
            nearest = min(same, key=lambda e: held.off(e.stamp))
            left.remove(nearest)
            off.append(held.off(nearest.stamp))
    return replace(line, false=len(left), missed=len(expected) - len(off), off=tuple(off))


def total(lines: Sequence[Line]) -> Line:
    """One line of all; ``rate`` is the median."""
    steps = [line.steps for line in lines if line.steps]
    return Line(
        f"all {len(lines)}",
        float(np.median([line.rate for line in lines])),
        sum(line.events for line in lines),
        sum(line.false or 0 for line in lines),
        sum(line.missed or 0 for line in lines),
        tuple(off for line in lines for off in line.off),
        (sum(right for right, _ in steps), sum(of for _, of in steps)) if steps else None,
    )


def run(words: Sequence[str] | None = None) -> str:
    """The table that the tool prints.

    Raises:
        MbdError: a folder that cannot be used.
    """
    parser = CommandParser(prog="demonstration_report", description="Print how well recordings are read.")
    parser.add_argument(
        "paths", nargs="+", type=Path, help="recordings, folders with traj.csv, or folders of such; see steps --help"
    )
    parser.add_argument("--polarity", type=Polarity, choices=list(Polarity), default=Polarity.LARGER_OPEN)
    parser.add_argument("--fingers", nargs="+", default=[], metavar="NAME", help="columns or joints of the gripper")
    parser.add_argument("--rate", type=above_zero, default=ROBOMIMIC_RATE, help="[Hz] of a layout without stamps")
    options = parser.parse_args(words)
    lines = []
    for path in options.paths:
        inside = sorted(p.parent for p in path.glob("**/traj.csv"))
        for one in inside or [path]:
            for episode in range(1 if inside else read_bounded(episodes_of, path)):
                selection = Selection(tuple(options.fingers), episode, options.rate)
                lines.append(line_of(one, options.polarity, selection))
    if len(lines) > 1:
        lines.append(total(lines))
    return "\n".join([HEAD, *map(str, lines)])


def main() -> None:
    """Print, or report why not and end with 2."""
    try:
        sys.stdout.write(run() + "\n")
    except MbdError as error:
        sys.stderr.write(f"demonstration_report: {error}\n")
        sys.exit(UNUSABLE)
