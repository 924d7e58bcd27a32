"""How far each feature of an object may be from the truth: its standard deviation, learned from many views.

The logarithm of a feature's standard deviation is linear in what can be seen of the object (`evidence_of_error.py`).
`fit_deviations` chose the weights so that 68 % of the errors lie within one and 95 % within two of them; errors of
segmentation, a piece too many or too few, count like any other. See docs/perception.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from mbd_model.camera.pose import CameraPose
from mbd_model.objects import FeatureDeviations, SceneObject

from mbd_perception.features.deviation_weights import WEIGHTS
from mbd_perception.features.evidence_of_error import EVIDENCE, Floats, MeasuredObject, error_evidence
from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.segment import Segmentation

# What is predicted. Level places along and across the line of sight, seen from above.
DEVIATIONS = (
    *("centroid_along", "centroid_across", "centroid_up"),
    *("box_center_along", "box_center_across", "box_center_up"),
    *("long", "short", "height", "yaw", "volume", "hue", "saturation"),
)
# How noisy cameras were whose errors taught each deviation: std of inverse depth [1/m]. What needs the true extent of
# an object was learned from rendered rooms, the rest from Kinect frames too. With more noise deviations grow in
# proportion, for sides become longer and volumes larger the more noise there is.
ROOMS_NOISE, FRAMES_NOISE = 2e-3, 3.7e-3
LEARNED_NOISE = np.array(
    [FRAMES_NOISE if name.startswith(("centroid", "height", "hue", "sat")) else ROOMS_NOISE for name in DEVIATIONS]
)
# What depth noise does not make worse: colours.
GROWS = np.array([name not in ("hue", "saturation") for name in DEVIATIONS])
LARGEST = {"yaw": math.pi / 4, "hue": 90.0, "saturation": 0.5, "volume": 2.0}


def predicted(evidence: Floats, weights: Floats = WEIGHTS) -> Floats:
    """(n, 13) standard deviations, in the order of ``DEVIATIONS``.

    Metres, yaw in radians, hue in degrees, volume as a share of itself.

    Args:
        evidence: (n, len(EVIDENCE)).
        weights: (2 + 13, 1 + len(EVIDENCE)): the least and the largest evidence that was learned from, beyond which
            nothing is extrapolated but noise, then bias and weights of each deviation.
    """
    low, high, model = weights[0, 1:], weights[1, 1:], weights[2:]
    within = np.clip(evidence, low, high)
    distance, noise = (EVIDENCE.index(name) for name in ("distance", "noise"))
    # (n, 13): the noise that was learned from, at this distance, and how much more there is.
    learned = np.log(LEARNED_NOISE) + 2.0 * evidence[:, distance, None]
    used = np.clip(np.minimum(evidence[:, noise, None], learned), low[noise], high[noise])
    beyond = np.maximum(evidence[:, noise, None] - np.minimum(learned, high[noise]), 0.0) * GROWS
    within[:, noise] = 0.0
    logs = model[:, 0] + within @ model[:, 1:].T + used * model[:, 1 + noise] + beyond
    most = np.array([LARGEST.get(name, 0.5) for name in DEVIATIONS])
    return np.asarray(np.minimum(np.exp(logs), most))


def feature_deviations(
    frame: RgbdFrame, segmentation: Segmentation, pose: CameraPose, measured: Sequence[MeasuredObject]
) -> list[FeatureDeviations]:
    """The standard deviations of each object; arguments as of ``error_evidence``."""
    std = predicted(error_evidence(frame, segmentation, pose, measured))
    return [_of(m.object, row.tolist(), pose) for m, row in zip(measured, std, strict=True)]


def _of(obj: SceneObject, std: Sequence[float], pose: CameraPose) -> FeatureDeviations:
    """Those of one object, from a row of ``predicted``."""
    named = dict(zip(DEVIATIONS, std, strict=True))
    x, y = (float(v) for v in np.asarray(obj.centroid)[:2] - pose.position[:2])
    length = math.hypot(x, y)
    cos, sin = (x / length, y / length) if length > 1e-6 else (1.0, 0.0)

    def place(name: str) -> tuple[float, float, float]:
        along, across = named[f"{name}_along"], named[f"{name}_across"]
        return math.hypot(along * cos, across * sin), math.hypot(along * sin, across * cos), named[f"{name}_up"]

    width, depth, _ = obj.size
    level = (named["long"], named["short"]) if width >= depth else (named["short"], named["long"])
    return FeatureDeviations(
        centroid=place("centroid"),
        box_center=place("box_center"),
        size=(*level, named["height"]),
        yaw=named["yaw"],
        volume=named["volume"] * obj.volume,
        hue=None if obj.hue is None else named["hue"],
        saturation=named["saturation"],
    )
