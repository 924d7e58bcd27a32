"""How far measured features are from the truth, in rendered rooms and in labelled frames."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from mbd_model.camera.pose import CameraPose, pose_above_plane
from mbd_model.errors import MbdError
from mbd_model.objects import SceneObject
from mbd_perception.features.deviations import DEVIATIONS
from mbd_perception.features.evidence_of_error import error_evidence
from mbd_perception.features.knowledge import KnowledgeBase
from mbd_perception.features.measure import MeasureConfig, measure
from mbd_perception.frames.files import load_frame
from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.segment import Segmentation, SegmentationConfig, segment
from mbd_perception.synthetic.rooms import Kind, furnished, photographed
from numpy.typing import NDArray

from mbd_experiments.perception_training.feature_truth import Floats, TrueFeatures, true_features

# Classes do not matter here: size and hue are measured without them.
NO_CLASSES = KnowledgeBase(classes=())


@dataclass(frozen=True)
class FeatureError:
    """One measured object and a true one.

    Attributes:
        scene: where it stood; objects of one scene are never split between fitting and report.
        evidence: (k,) what of it could be seen, see ``error_evidence``.
        errors: (13,) measured less true, in the order and units of ``DEVIATIONS``; NaN where there is no truth.
        owned: whether the true object is the one it lies on: each measured object has one such pair.
        best: whether it covers more of the true object than any other: each true object that was found has one such
            pair.
    """

    scene: str
    evidence: Floats
    errors: Floats
    owned: bool
    best: bool

    @property
    def centroid(self) -> float:
        """Distance of the centroid from the true one [m]."""
        return float(np.linalg.norm(self.errors[:3]))


def room_errors(kind: Kind, numbers: Iterable[int], views: int) -> Iterator[FeatureError]:
    """The objects of rendered rooms of a kind, each seen from several places; camera pose given.

    Args:
        kind: of the rooms.
        numbers: seeds; rooms that are learned from have numbers below 1000.
        views: from how many places each is seen.
    """
    for number in numbers:
        rng = np.random.default_rng([zlib.crc32(kind.name.encode()), number])
        unseen = furnished(kind, rng)
        for _ in range(views):
            room = photographed(unseen, rng)
            found = _segmented(room.view.frame, room.view.pose)
            if found is None:
                continue
            known = {k: true_features(room, k, kind is not Kind.GREY) for k in np.unique(room.truth) if k}
            yield from scene_errors(f"{kind.name} {number}", found, room.truth, known)


def folder_errors(folder: Path) -> Iterator[FeatureError]:
    """The objects of a labelled frame folder; in its labels.png 0 and 1 are no objects.

    The truth is measured from the labels, so it is that of what can be seen; the height is the one that meta.json
    states, where it does.

    Raises:
        MbdError: the folder is no frame, its labels are missing, or no table is in view.
    """
    frame = load_frame(folder)
    labels = cv2.imread(str(folder / "labels.png"), cv2.IMREAD_UNCHANGED)
    if labels is None or labels.shape != frame.depth.shape:
        raise MbdError(f"{folder / 'labels.png'} is missing or not of the size of depth.png: its truth is needed")
    truth = np.where((labels > 1) & (frame.depth > 0), labels.astype(np.int32) - 1, 0).astype(np.int32)
    found = _Found(frame, segmentation := segment(frame, None, SegmentationConfig()), _pose_of(segmentation))
    by_label = replace(segmentation, labels=truth, count=int(truth.max()))
    heights = _stated_heights(folder / "meta.json")
    known = {}
    for m in measure(frame, by_label, found.pose, NO_CLASSES, MeasureConfig()):
        if np.count_nonzero(truth == m.label) >= 60:
            width, depth, height = m.object.size
            known[m.label] = TrueFeatures(
                np.asarray(m.object.centroid),
                size=(width, depth, heights.get(m.label + 1, height)),
                hue=m.object.hue,
                saturation=m.object.saturation,
            )
    yield from scene_errors(folder.name, found, truth, known)


def _stated_heights(meta: Path) -> dict[int, float]:
    """Of each label of labels.png its height above the table [m], where a frame's meta.json states any."""
    document = json.loads(meta.read_text(encoding="utf-8-sig"))
    return {
        int(thing["id"]): float(thing["height_above_table_m_p2_p98"][1])
        for thing in document.get("gt_objects", ())
        if "height_above_table_m_p2_p98" in thing
    }


@dataclass(frozen=True)
class _Found:
    """What was found in a frame, and the camera's pose it is measured with."""

    frame: RgbdFrame
    segmentation: Segmentation
    pose: CameraPose


def _segmented(frame: RgbdFrame, pose: CameraPose) -> _Found | None:
    """None where no table is in view: there is then nothing measured."""
    try:
        return _Found(frame, segment(frame, pose, SegmentationConfig()), pose)
    except MbdError:
        return None


def _pose_of(segmentation: Segmentation) -> CameraPose:
    return pose_above_plane(segmentation.plane.normal, segmentation.plane.offset)


def scene_errors(
    scene: str, found: _Found, truth: NDArray[np.int32], known: Mapping[int, TrueFeatures]
) -> Iterator[FeatureError]:
    """One for each object that was found with the true one it lies on, and for each true one with what covers it most.

    Args:
        scene: its name.
        found: frame, segmentation and pose.
        truth: (height, width) true objects, 0 = none.
        known: of each, its true features.
    """
    labels = found.segmentation.labels
    measured = measure(found.frame, found.segmentation, found.pose, NO_CLASSES, MeasureConfig())
    evidence = error_evidence(found.frame, found.segmentation, found.pose, measured)
    width = int(truth.max()) + 1
    shared = np.bincount((labels * width + truth).ravel(), minlength=(int(labels.max()) + 1) * width)
    shared = shared.reshape(-1, width)
    shared[0] = 0
    for row, m in zip(evidence, measured, strict=True):
        count = shared[m.label, 1:]
        owner = int(count.argmax()) + 1 if count.any() and count.max() >= 0.3 * shared[m.label].sum() else 0
        for number, true in known.items():
            best = shared[m.label, number] > 0 and int(shared[:, number].argmax()) == m.label
            if best or number == owner:
                yield FeatureError(scene, row, feature_error(m.object, true, found.pose), number == owner, best)


def feature_error(obj: SceneObject, true: TrueFeatures, pose: CameraPose) -> Floats:
    """(13,) measured less true, in the order and units of ``DEVIATIONS``; NaN where there is no truth."""
    error = dict.fromkeys(DEVIATIONS, math.nan)
    sight = np.asarray(obj.centroid)[:2] - pose.position[:2]
    along = sight / max(float(np.linalg.norm(sight)), 1e-9)
    across = np.array([-along[1], along[0]])
    places = [("centroid", obj.centroid, true.centroid)]
    if true.box_center is not None and obj.box_center is not None:
        places.append(("box_center", obj.box_center, true.box_center))
    for name, is_at, should_be in places:
        off = np.asarray(is_at) - should_be
        error[f"{name}_along"], error[f"{name}_across"] = float(off[:2] @ along), float(off[:2] @ across)
        error[f"{name}_up"] = float(off[2])
    if true.size is not None:
        width, depth, height = true.size
        if true.yaw is not None:
            quarters = round((obj.yaw - true.yaw) / (math.pi / 2))
            error["yaw"] = obj.yaw - true.yaw - quarters * math.pi / 2
            if quarters % 2:
                width, depth = depth, width
        sides = (obj.size[0] - width, obj.size[1] - depth)
        error["long"], error["short"] = sides if obj.size[0] >= obj.size[1] else sides[::-1]
        error["height"] = obj.size[2] - height
        error["volume"] = obj.volume / (width * depth * height) - 1.0
    if obj.hue is not None and true.hue is not None:
        error["hue"] = (obj.hue - true.hue + 180.0) % 360.0 - 180.0
    if true.saturation is not None:
        error["saturation"] = obj.saturation - true.saturation
    return np.array([error[name] for name in DEVIATIONS])
