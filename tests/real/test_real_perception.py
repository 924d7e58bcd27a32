"""Perception on the real Kinect frames it was made with (../shared/rgbd; skipped when absent)."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import Observation, ObserveConfig, observe
from mbd_perception.frames.files import load_frame
from mbd_perception.synthetic.scoring import Score, score

ROOT = Path(__file__).parents[2]
# Frames perception was made with. What it reaches on the others is reported in docs/perception.md, not held.
FIRST = ("learn0", "learn3", *(f"learn{k}" for k in (*range(12, 18), 21, 25, *range(33, 36), *range(37, 41), 43, 44)))
FRAMES = [f for name in FIRST if (f := ROOT.parent / "shared/rgbd" / f"mosd_{name}").is_dir()]
KNOWLEDGE = load_knowledge(ROOT / "ros2_ws/src/mbd_perception/config/knowledge.yaml")
pytestmark = pytest.mark.skipif(not FRAMES, reason="no real frames: ../shared/rgbd is absent")


@cache
def seen(folder: Path) -> tuple[Observation, Score, Any]:
    """(observation, its score, meta.json) of a frame."""
    from mbd_model.objects import Role

    frame = load_frame(folder)
    observation = observe(frame, Role.SOURCE, None, ObserveConfig(knowledge=KNOWLEDGE))
    truth = cv2.imread(str(folder / "labels.png"), cv2.IMREAD_UNCHANGED).astype(int)
    result = score(observation.segmentation.labels, np.where(truth > 1, truth, 0), frame.depth > 0)
    return observation, result, json.loads((folder / "meta.json").read_text(encoding="utf-8"))


def matched() -> list[tuple[Any, Any, Observation]]:
    """(true object, the scene object that overlaps it most, observation) for every true object."""
    pairs = []
    for folder in FRAMES:
        observation, _, meta = seen(folder)
        truth = cv2.imread(str(folder / "labels.png"), cv2.IMREAD_UNCHANGED)
        for real in meta["gt_objects"]:
            inside = observation.segmentation.labels[truth == real["id"]]
            label = int(np.bincount(inside[inside > 0]).argmax())
            found = observation.scene.objects[observation.labels.index(label)]
            pairs.append((real, found, observation))
    return pairs


def test_overlap() -> None:
    """The mean weighted overlap with the truth is at least 0.94."""
    assert np.mean([seen(f)[1].weighted_overlap for f in FRAMES]) >= 0.94


def test_counts() -> None:
    """At least nine tenths of the frames have the right number of objects, and nothing is seen where nothing is."""
    assert np.mean([seen(f)[1].right_count for f in FRAMES]) >= 17 / 19
    assert sum(seen(f)[1].false_objects for f in FRAMES) == 0


def test_table() -> None:
    """The table is the plane that was fitted to its true pixels, within a degree and 5 mm."""
    for folder in FRAMES:
        observation, _, meta = seen(folder)
        truth = meta["verification"]
        plane = observation.segmentation.plane
        assert np.degrees(plane.tilt(np.array(truth["plane_normal_cam"]))) < 1.0
        assert abs(plane.offset - truth["camera_height_above_plane_m"]) < 0.005


def test_centroids() -> None:
    """Centroids lie within 10 mm of the truth's (median)."""
    errors = []
    for real, found, observation in matched():
        truth = observation.pose.to_base(np.array([real["centroid_cam_m"]]))[0]
        errors.append(np.linalg.norm(truth - found.centroid))
    assert np.median(errors) < 0.010


def test_heights() -> None:
    """Heights are within 6 mm of the truth's (median)."""
    errors = [abs(found.size[2] - real["height_above_table_m_p2_p98"][1]) for real, found, _ in matched()]
    assert np.median(errors) < 0.006


def test_hues() -> None:
    """Objects with one colour have its hue within 12 degrees."""
    for real, found, _ in matched():
        if real["mean_sat"] > 0.25 and real["hue_concentration"] > 0.8:
            assert found.hue is not None
            assert abs((found.hue - real["hue_deg_sat_weighted"] + 180) % 360 - 180) < 12


def test_deviations() -> None:
    """Nine tenths of the errors of centroid and height lie within two standard deviations, a third beyond half."""
    shares = []
    for real, found, observation in matched():
        std = found.deviations
        assert std is not None
        truth = observation.pose.to_base(np.array([real["centroid_cam_m"]]))[0]
        off = (*(truth - found.centroid), found.size[2] - real["height_above_table_m_p2_p98"][1])
        shares.append(np.abs(off) / (*std.centroid, std.size[2]))
    assert np.mean(np.array(shares) < 2.0) > 0.9
    assert np.mean(np.array(shares) > 0.5) > 1 / 3
