"""What of an object can be seen that tells how exactly it is measured: how far, how little, how much hidden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from mbd_model.camera.pose import CameraPose
from mbd_model.objects import SceneObject
from numpy.typing import NDArray

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.segment import Segmentation

Floats = NDArray[np.float64]

# The columns of ``error_evidence``; deviation_weights.py has a weight for each.
EVIDENCE = (
    "pixels",  # log of how many show
    "distance",  # log [m] from the camera
    "noise",  # log of the std of one depth [m]
    "long",  # log of the longer level side [m]
    "short",  # log of the shorter one [m]
    "height",  # log [m]
    "shown",  # log of the area seen over that of its box seen from there
    "hidden",  # share of the outline at which something nearer begins
    "touching",  # share at which another object begins, neither nearer nor farther
    "cut",  # share at which the picture ends or has no depth
    "from_above",  # sine of the angle at which the camera looks down on it
    "turned",  # 1 when its box is
    "saturation",
    "motley",  # circular std of its hues [rad]
)
STEP = 4


class MeasuredObject(Protocol):
    """An object as measured, its label in the picture, and how much its hues agree, 0..1."""

    @property
    def object(self) -> SceneObject:
        """Its features, base frame."""
        ...

    @property
    def label(self) -> int:
        """Its number in the label picture."""
        ...

    @property
    def agreement(self) -> float:
        """1 when all of it is of one hue, 0 when its hues cancel out."""
        ...


@dataclass(frozen=True)
class Outlines:
    """Of each label, 0 = none: how many pixels show, and shares of its outline, (count + 1,) each."""

    pixels: Floats
    hidden: Floats
    touching: Floats
    cut: Floats


def outlines(frame: RgbdFrame, segmentation: Segmentation) -> Outlines:
    """What lies along the outline of each object, from every fourth row and column: for shares that will do."""
    count = segmentation.count + 1
    totals = np.zeros((4, count))
    jump = 4.0 * segmentation.noise
    across = segmentation.labels[::STEP], frame.depth[::STEP]
    down = (np.ascontiguousarray(picture[:, ::STEP].T) for picture in (segmentation.labels, frame.depth))
    for labels, depth in (across, tuple(down)):
        row, column = np.nonzero(labels[:, 1:] != labels[:, :-1])
        left, right = labels[row, column], labels[row, column + 1]
        z_left, z_right = depth[row, column], depth[row, column + 1]
        for mine, other, z, beyond in ((left, right, z_left, z_right), (right, left, z_right, z_left)):
            step = beyond - z
            close = np.abs(step) <= jump * z * z + 0.01 * z
            seen = beyond > 0
            kinds = (seen & (step < 0) & ~close, seen & close & (other > 0), ~seen)
            totals[0] += np.bincount(mine, minlength=count)
            for number, kind in enumerate(kinds, start=1):
                totals[number] += np.bincount(mine[kind], minlength=count)
        for edge in (labels[:, 0], labels[:, -1]):
            at_edge = np.bincount(edge, minlength=count)
            totals[0] += at_edge
            totals[3] += at_edge
    flat = across[0][across[0] > 0]
    pixels = STEP * np.bincount(flat, minlength=count).astype(np.float64)
    return Outlines(pixels, *(totals[1:] / np.maximum(totals[0], 1)))


def error_evidence(
    frame: RgbdFrame, segmentation: Segmentation, pose: CameraPose, measured: Sequence[MeasuredObject]
) -> Floats:
    """One row for each object, one column for each of ``EVIDENCE``.

    Args:
        frame: what was seen.
        segmentation: the objects in it.
        pose: camera2base.
        measured: n objects.

    Returns:
        (n, len(EVIDENCE)).
    """
    along = outlines(frame, segmentation)
    pixels = np.maximum(along.pixels, 1.0)
    camera, rows = frame.camera, []
    for obj, label, agreement in ((m.object, m.label, m.agreement) for m in measured):
        ray = pose.position - np.asarray(obj.centroid)
        distance = float(np.linalg.norm(ray))
        down = float(np.clip(ray[2] / distance, 0.05, 1.0))
        width, depth, height = obj.size
        silhouette = width * depth * down + max(width, depth) * height * float(np.sqrt(1.0 - min(down, 0.995) ** 2))
        area = pixels[label] * distance**2 / (camera.fx * camera.fy)
        rows.append(
            (
                np.log(pixels[label]),
                np.log(distance),
                np.log(segmentation.noise * distance**2 + 1e-5),
                np.log(max(width, depth)),
                np.log(min(width, depth)),
                np.log(height),
                np.log(area / silhouette),
                along.hidden[label],
                along.touching[label],
                along.cut[label],
                down,
                float(obj.yaw != 0.0),
                obj.saturation,
                np.sqrt(-2.0 * np.log(np.clip(agreement, 1e-3, 1.0))),
            )
        )
    return np.array(rows, dtype=np.float64).reshape(-1, len(EVIDENCE))
