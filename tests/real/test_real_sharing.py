"""Shared pictures of real tables (../shared/rgbd; skipped when absent) keep every object that stands on the table."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import pose_above_plane
from mbd_perception.frames.frame import make_frame
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.segmentation.workspace import Workspace
from mbd_study.sharing.pictures.faces import FaceFinder
from mbd_study.sharing.pictures.volume import TableVolume

ROOT = Path(__file__).parents[2].parent / "shared" / "rgbd"
FRAMES = [path for n in ("learn0", "learn12", "learn21", "learn35", "learn40") if (path := ROOT / f"mosd_{n}").is_dir()]
MARGIN = 0.05  # [m] of the table around its objects that somebody would count to the workspace

pytestmark = pytest.mark.skipif(not FRAMES, reason="no real frames: ../shared/rgbd is absent")


@pytest.mark.parametrize("path", FRAMES, ids=lambda path: path.name)
def test_every_labelled_object_stays_and_what_is_outside_of_the_workspace_does_not(path: Path):
    color = cv2.imread(str(path / "color.png"))[..., ::-1].copy()
    raw = cv2.imread(str(path / "depth.png"), cv2.IMREAD_UNCHANGED)
    labels = cv2.imread(str(path / "labels.png"), cv2.IMREAD_UNCHANGED)
    optics = json.loads((path / "meta.json").read_text())["camera"]
    camera = Intrinsics(*(optics[name] for name in ("fx", "fy", "cx", "cy")), width=raw.shape[1], height=raw.shape[0])
    frame = make_frame(color, raw, camera)
    plane = segment(frame, None, SegmentationConfig()).plane
    pose = pose_above_plane(plane.normal, plane.offset)
    columns, rows = camera.rays()
    points = np.stack([columns * frame.depth, rows * frame.depth, frame.depth], axis=-1).astype(np.float64)
    objects = (labels > 1) & (frame.depth > 0)
    on_table = pose.to_base(points[objects])
    (x, y, _), (far_x, far_y, _) = on_table.min(axis=0) - MARGIN, on_table.max(axis=0) + MARGIN
    volume = TableVolume(camera, pose, Workspace((x, far_x), (y, far_y), (-0.05, 0.5)))
    kept = volume.seen(frame.depth)
    assert kept[objects].all()
    # Holes in an object stay with what surrounds them; a few lie deep in what no depth was got of.
    assert kept[labels > 1].mean() > 0.99
    outside = (frame.depth > 0) & ~volume.contains(pose.to_base(points.reshape(-1, 3))).reshape(raw.shape)
    assert not kept[outside & ~cv2.dilate((~outside).astype(np.uint8), np.ones((3, 3))).astype(bool)].any()
    # A table is no face.
    assert FaceFinder().find(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY), volume.face_pixels) == []
