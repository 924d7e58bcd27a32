"""How well and how fast perception segments, set by set, as a table; beside PCL where that can be built.

`python -m pytest benchmarks/test_perception_sets.py --benchmark-only` (part of `make bench`). The sets are kept apart:
values were chosen by `first` and `choose`; by `report` nothing is chosen, so that only it tells how perception does on
tables nobody has seen (docs/perception.md states the split). Time is processor time of one thread, frame in memory to
objects with features, the best of three; PCL's is that of its segmentation alone (benchmarks/pcl/segment.cpp).
"""

from __future__ import annotations

import shutil
import struct
import subprocess
import time
import zlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.frames.files import load_frame
from mbd_perception.frames.frame import FrameError, RgbdFrame
from mbd_perception.synthetic.rooms import Kind, random_room
from mbd_perception.synthetic.scoring import Score, score

ROOT = Path(__file__).parents[1]
REAL = sorted((ROOT.parent / "shared/rgbd").glob("mosd_*"))
CASES = sorted((ROOT.parent / "shared/cases/perception").glob("*"))
CONFIG = ObserveConfig(knowledge=load_knowledge(ROOT / "ros2_ws/src/mbd_perception/config/knowledge.yaml"))
FIRST = {f"mosd_learn{k}" for k in (0, 3, *range(12, 18), 21, 25, *range(33, 36), *range(37, 41), 43, 44)}
REPEATS = 3
ROOMS = 2  # of each kind


@dataclass(frozen=True)
class LabelledFrame:
    """A frame with its truth, (height, width), 0 = no object, and which pixels count."""

    frame: RgbdFrame
    truth: np.ndarray
    valid: np.ndarray


@dataclass(frozen=True)
class Outcome:
    """How well one frame was segmented, and the processor time that took [s]."""

    score: Score
    seconds: float


def labelled(folders: Sequence[Path]) -> Iterator[LabelledFrame]:
    """The frames of folders; one that cannot be read or has no object in its truth is left out."""
    for folder in folders:
        if not (folder / "labels.png").exists():
            continue
        truth: Any = cv2.imread(str(folder / "labels.png"), cv2.IMREAD_UNCHANGED)
        try:
            frame = load_frame(folder)
        except FrameError:
            continue
        if truth.max() > 1:
            yield LabelledFrame(frame, np.where(truth > 1, truth, 0).astype(np.int32), frame.depth > 0)


def rooms() -> Iterator[LabelledFrame]:
    """Rendered rooms of every kind, of other seeds than those that were looked at."""
    for kind in Kind:
        for number in range(ROOMS):
            room = random_room(kind, np.random.default_rng([zlib.crc32(kind.name.encode()), 2000 + number]))
            yield LabelledFrame(room.view.frame, room.truth, room.valid)


def sets() -> dict[str, list[LabelledFrame]]:
    """Every set that is at hand, under what it is called in the table."""
    others = [f for f in REAL if f.name not in FIRST]
    found = {
        "first (chosen by)": list(labelled([f for f in REAL if f.name in FIRST])),
        "choose (chosen by)": list(labelled(others[0::2])),
        "cases (chosen by)": list(labelled(CASES)),
        "rendered rooms (chosen by other seeds)": list(rooms()),
        "**report** (kept apart)": list(labelled(others[1::2])),
    }
    return {name: frames for name, frames in found.items() if frames}


def ours(frames: list[LabelledFrame]) -> list[Outcome]:
    """What this package makes of frames; an error is a frame without objects."""
    outcomes = []
    for case in frames:
        labels, best = np.zeros(case.truth.shape, dtype=np.int32), np.inf
        for _ in range(REPEATS):
            begun = time.process_time()
            with suppress(MbdError):
                labels = observe(case.frame, Role.SOURCE, None, CONFIG).segmentation.labels
            best = min(best, time.process_time() - begun)
        outcomes.append(Outcome(score(labels, case.truth, case.valid), best))
    return outcomes


def pcl(program: Path, frames: list[LabelledFrame]) -> list[Outcome]:
    """What PCL makes of frames."""
    sent = b"".join(
        struct.pack("<2i4d", c.width, c.height, c.fx, c.fy, c.cx, c.cy) + depth.astype("<f4").tobytes()
        for c, depth in ((case.frame.camera, case.frame.depth) for case in frames)
    )
    answer = subprocess.run([program, str(REPEATS)], input=sent, stdout=subprocess.PIPE, check=True).stdout
    outcomes, at = [], 0
    for case in frames:
        (seconds,) = struct.unpack_from("<d", answer, at)
        labels = np.frombuffer(answer, "<i4", case.truth.size, at + 8).reshape(case.truth.shape)
        at += 8 + labels.nbytes
        outcomes.append(Outcome(score(labels, case.truth, case.valid), seconds))
    return outcomes


def built(folder: Path) -> Path | None:
    """The program of benchmarks/pcl, built; None where there is no compiler or no PCL (libpcl-dev)."""
    packages = ("pcl_features", "pcl_segmentation")
    if shutil.which("c++") is None or shutil.which("pkg-config") is None:
        return None
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", *packages], check=False, capture_output=True, text=True)
    if flags.returncode != 0:
        return None
    program = folder / "segment"
    source = ROOT / "benchmarks/pcl/segment.cpp"
    command = ["c++", "-O2", "-DNDEBUG", "-std=c++17", str(source), "-o", str(program), *flags.stdout.split()]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, f"{source} cannot be built with {' '.join(command)}:\n{done.stderr[-2000:]}"
    return program


def mean_time(outcomes: list[Outcome]) -> float:
    """Mean processor time of a frame [s]."""
    return float(np.mean([o.seconds for o in outcomes]))


def row(name: str, who: str, outcomes: list[Outcome], ratio: str) -> str:
    """One line of the table."""
    scores = [o.score for o in outcomes]
    means = [
        float(np.mean([getattr(s, key) for s in scores]))
        for key in ("weighted_overlap", "over_segmentation", "under_segmentation")
    ]
    right, false = sum(s.right_count for s in scores), sum(s.false_objects for s in scores)
    found, expected = sum(s.found for s in scores), sum(s.expected for s in scores)
    numbers = " | ".join(f"{m:.3f}" for m in means)
    return (
        f"| {name} | {who} | {numbers} | {right} of {len(scores)} | {found} of {expected} | {false} "
        f"| {1000 * mean_time(outcomes):.1f} ms | {ratio} |"
    )


@pytest.fixture
def one_thread() -> Iterator[None]:
    """One thread of OpenCV, as in the node."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    yield
    cv2.setNumThreads(before)


@pytest.mark.usefixtures("one_thread")
@pytest.mark.timeout(1800)
def test_sets(benchmark: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Set by set: overlap, over- and under-segmentation, right counts, objects, false ones, time."""
    program = built(tmp_path)
    lines: list[str] = []

    def everything() -> None:
        for name, frames in sets().items():
            mine = ours(frames)
            rival = pcl(program, frames) if program else []
            ratio = f"{mean_time(mine) / mean_time(rival):.3f}" if rival else "no PCL here"
            lines.append(row(name, "this", mine, ratio))
            lines.extend([row(name, "PCL", rival, "1")] if rival else [])

    benchmark.pedantic(everything, rounds=1, iterations=1)
    with capsys.disabled():
        head = ("set", "whose", "WOv", "over", "under", "right count", "objects found", "false", "time", "of PCL's")
        print(f"\n| {' | '.join(head)} |\n|{'---|' * len(head)}")
        print("\n".join(lines))
    assert lines
