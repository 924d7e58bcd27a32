"""How long perception takes for a frame, by stage, one thread, frame in memory; and how much memory.

On the real frames of ../shared/rgbd where they are, on synthetic ones where they are not. PCL 1.13 in C++
takes 64 ms for such a frame (see ../shared/rgbd/README.md), a camera period is 33 ms.
"""

from __future__ import annotations

import itertools
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import pose_above_plane
from mbd_model.objects import Role
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig, measure, observe
from mbd_perception.frames.files import load_frame
from mbd_perception.frames.frame import RgbdFrame, fuse
from mbd_perception.segmentation.components import surface_components
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.segmentation.separation import separate
from mbd_perception.segmentation.table.choice import supporting_plane
from mbd_perception.segmentation.table.extent import ExtentConfig, table_outline
from mbd_perception.segmentation.table.plane import PlaneConfig
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render

ROOT = Path(__file__).parents[1]
FOLDERS = sorted((ROOT.parent / "shared/rgbd").glob("mosd_*"))
CONFIG = ObserveConfig(knowledge=load_knowledge(ROOT / "ros2_ws/src/mbd_perception/config/knowledge.yaml"))
SEGMENTATION = SegmentationConfig()
PERIOD_MS = 1000 / 30
PCL_MS = 64.0
HD = Intrinsics(fx=1050.0, fy=1050.0, cx=639.5, cy=359.5, width=1280, height=720)


def synthetic(camera: Intrinsics | None = None) -> RgbdFrame:
    """A table with seven things on it."""
    pose = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))
    solids: list[Box | Cylinder] = [
        Cylinder((0.5 + 0.15 * (i % 3), -0.3 + 0.2 * (i // 3), 0.0), 0.04, 0.09, (200, 30 * i, 60), wall=0.004)
        for i in range(6)
    ]
    solids.append(Box((0.8, 0.2, 0.0), (0.1, 0.2, 0.15), (60, 60, 200), 0.4))
    rng = np.random.default_rng(0)
    return render(solids, pose, rng, camera=camera).frame if camera else render(solids, pose, rng).frame


@pytest.fixture(scope="module")
def frames() -> list[RgbdFrame]:
    """What is measured on."""
    return [load_frame(folder) for folder in FOLDERS] or [synthetic()]


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """One thread of OpenCV, as in the node."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    yield
    cv2.setNumThreads(before)


def report(benchmark: Any, capsys: pytest.CaptureFixture[str], what: str) -> None:
    """Report what was measured and how it compares."""
    median = 1000 * benchmark.stats.stats.median
    with capsys.disabled():
        print(
            f"\n{what}: median {median:.1f} ms = {median / PERIOD_MS:.2f} camera periods (30 Hz)"
            f" = {median / PCL_MS:.2f} of PCL's C++ ({PCL_MS:.0f} ms)"
        )


def run(benchmark: Any, frames: list[Any], work: Callable[[Any], object]) -> None:
    """Time ``work`` on the frames in turn, after each has been seen once."""
    for frame in frames:
        work(frame)
    turn = itertools.cycle(frames)
    benchmark.pedantic(work, setup=lambda: ((next(turn),), {}), rounds=6 * max(len(frames), 10), iterations=1)


def kind(frames: list[RgbdFrame]) -> str:
    """What the frames are."""
    return f"{len(frames)} real Kinect frames, 640x480" if FOLDERS else "a synthetic frame, 640x480"


def test_frame_to_objects(benchmark: Any, frames: list[RgbdFrame], capsys: pytest.CaptureFixture[str]) -> None:
    """Frame in memory to objects with features."""
    run(benchmark, frames, lambda f: observe(f, Role.SOURCE, None, CONFIG))
    report(benchmark, capsys, f"frame to objects with features ({kind(frames)})")


def test_hd(benchmark: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """The same for 1280x720, synthetic."""
    run(benchmark, [synthetic(HD)], lambda f: observe(f, Role.SOURCE, None, CONFIG))
    report(benchmark, capsys, "frame to objects with features (a synthetic frame, 1280x720)")


def test_stage_plane(benchmark: Any, frames: list[RgbdFrame], capsys: pytest.CaptureFixture[str]) -> None:
    """Stage 1: the table's plane and outline."""

    def work(frame: RgbdFrame) -> None:
        plane = supporting_plane(frame.depth, frame.camera, PlaneConfig())
        table_outline(frame.depth, frame.camera, plane, 2e-3, ExtentConfig())

    run(benchmark, frames, work)
    report(benchmark, capsys, "stage table")


def rising(frame: RgbdFrame) -> tuple[RgbdFrame, np.ndarray, np.ndarray]:
    """(frame, heights, what rises above the table)."""
    plane = supporting_plane(frame.depth, frame.camera, PlaneConfig())
    heights = plane.height(frame.depth, frame.camera)
    return frame, heights, (heights > 0.012) & (frame.depth > 0)


def test_stage_components(benchmark: Any, frames: list[RgbdFrame], capsys: pytest.CaptureFixture[str]) -> None:
    """Stage 2: organized connected components, over the complete picture."""
    run(
        benchmark,
        [rising(f) for f in frames],
        lambda r: surface_components(r[0].depth, r[2], r[0].camera, SEGMENTATION.jump),
    )
    report(benchmark, capsys, "stage connected components (complete picture)")


def test_stage_separation(benchmark: Any, frames: list[RgbdFrame], capsys: pytest.CaptureFixture[str]) -> None:
    """Stage 3: creases, regions, merging, over the complete picture."""
    ready = []
    for frame in frames:
        _, heights, mask = rising(frame)
        _, surfaces = surface_components(frame.depth, mask, frame.camera, SEGMENTATION.jump)
        ready.append((frame, surfaces, heights, (frame.depth > 0) & ~mask))
    run(
        benchmark,
        ready,
        lambda r: separate(*r, noise=2e-3, jump=SEGMENTATION.jump, config=SEGMENTATION.separation),
    )
    report(benchmark, capsys, "stage separation (complete picture)")


def test_stage_features(benchmark: Any, frames: list[RgbdFrame], capsys: pytest.CaptureFixture[str]) -> None:
    """Stage 4: features of the objects."""
    ready = []
    for frame in frames:
        found = segment(frame, None, SEGMENTATION)
        ready.append((frame, found, pose_above_plane(found.plane.normal, found.plane.offset)))
    run(benchmark, ready, lambda r: measure(*r, CONFIG.knowledge, CONFIG.measure))
    report(benchmark, capsys, "stage features")


def test_fusion(benchmark: Any, frames: list[RgbdFrame], capsys: pytest.CaptureFixture[str]) -> None:
    """The median of three frames, once an observation."""
    triples = [[replace(f, stamp=float(i)) for i in range(3)] for f in frames]
    run(benchmark, triples, fuse)
    report(benchmark, capsys, "fusing three frames (once an observation)")


def test_memory(benchmark: Any, frames: list[RgbdFrame], capsys: pytest.CaptureFixture[str]) -> None:
    """Memory over the frame stays below 60 MB."""
    peaks = []

    def work(frame: RgbdFrame) -> None:
        tracemalloc.start()
        observe(frame, Role.SOURCE, None, CONFIG)
        peaks.append(tracemalloc.get_traced_memory()[1] / 1e6)
        tracemalloc.stop()

    run(benchmark, frames, work)
    with capsys.disabled():
        print(f"\npeak memory over the frame: {max(peaks):.1f} MB")
    assert max(peaks) < 60
