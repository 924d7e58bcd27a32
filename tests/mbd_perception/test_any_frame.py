"""Whatever a camera delivers, perception answers with a scene or with a reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.frames.frame import make_frame
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render
from mbd_perception.synthetic.scoring import score

KNOWLEDGE = Path(__file__).parents[2] / "ros2_ws/src/mbd_perception/config/knowledge.yaml"
CONFIG = ObserveConfig(knowledge=load_knowledge(KNOWLEDGE))
SLANTED = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))
SOLIDS: list[Box | Cylinder] = [
    Box((0.6, 0.15, 0.0), (0.08, 0.12, 0.1), (200, 40, 40), 0.3),
    Cylinder((0.7, -0.15, 0.0), 0.05, 0.1, (40, 40, 200), wall=0.004),
]


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 70), st.integers(1, 70), st.integers(0, 2**32 - 1), st.sampled_from(("noise", "plane", "steps")))
def test_any_picture(height: int, width: int, seed: int, kind: str) -> None:
    """Pictures of any size, of noise, of a plane with holes, of steps: never anything but a scene or a reason."""
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.2, 6.0, (height, width))
    if kind == "plane":
        depth = 1.0 / (0.5 + np.linspace(0, 1.2, height)[:, None] + np.zeros(width)) + rng.normal(0, 1e-3, depth.shape)
        depth[rng.random(depth.shape) < 0.2] = np.nan
    elif kind == "steps":
        depth = np.round(depth * 2) / 2
    camera = Intrinsics(fx=60.0, fy=60.0, cx=width / 2, cy=height / 2, width=width, height=height)
    color = rng.integers(0, 256, (height, width, 3)).astype(np.uint8)
    pose = CameraPose(SLANTED.rotation, SLANTED.position) if seed % 2 else None
    try:
        scene = observe(make_frame(color, depth.astype(np.float32), camera), Role.SOURCE, pose, CONFIG).scene
    except MbdError as error:
        assert len(str(error)) > 30
    else:
        assert scene.objects


@settings(max_examples=6, deadline=None)
@given(st.floats(0.0, 0.3), st.integers(0, 1000))
def test_holes(share: float, seed: int) -> None:
    """With up to three tenths of its pixels missing, the table and what stands on it are still found."""
    rng = np.random.default_rng(seed)
    view = render(SOLIDS, SLANTED, rng)
    depth = np.where(rng.random(view.frame.depth.shape) < share, 0, view.frame.depth).astype(np.float32)
    frame = make_frame(view.frame.color, depth, view.frame.camera)
    found = segment(frame, None, SegmentationConfig())
    truth = np.where(view.labels > 1, view.labels, 0)
    assert score(found.labels, truth, depth > 0).right_count


@pytest.mark.parametrize(
    "camera",
    [
        Intrinsics(fx=260.0, fy=260.0, cx=159.5, cy=119.5, width=320, height=240),
        Intrinsics(fx=610.0, fy=611.0, cx=424.0, cy=240.0, width=848, height=480),
        Intrinsics(fx=1050.0, fy=1050.0, cx=639.5, cy=359.5, width=1280, height=720),
    ],
)
@pytest.mark.parametrize("noise", [3e-4, 1.5e-3, 3e-3])
def test_other_cameras(camera: Intrinsics, noise: float) -> None:
    """Other resolutions, lenses and noise need no other parameters."""
    view = render(SOLIDS, SLANTED, np.random.default_rng(0), camera=camera, noise=noise)
    found = segment(view.frame, None, SegmentationConfig())
    result = score(found.labels, np.where(view.labels > 1, view.labels, 0), view.frame.depth > 0)
    assert result.right_count
    assert result.false_objects == 0
    assert result.weighted_overlap > 0.9
