"""Organized connected components: pixels of one surface, separated at jumps in depth (Trevor et al. 2013, sec. IV)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.frame import DEPTH_NOISE, FloatImage

Labels = NDArray[np.int32]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class JumpConfig:
    """When two neighbouring pixels belong to different surfaces.

    Attributes:
        noise: std of inverse depth [1/m] of the sensor.
        grazing: steepest angle [rad] between line of sight and surface normal that still is one surface.
        sigmas: how many std of noise on top.
    """

    noise: float = DEPTH_NOISE
    grazing: float = 1.4
    sigmas: float = 4.0


def renumbered(labels: Labels, numbers: NDArray[np.integer]) -> Labels:
    """Label k becomes ``numbers[k]``, (height, width) int32; the labels themselves are not negative."""
    table = numbers.astype(np.int32)
    if len(table) > 256:
        return table.take(labels)
    # A table of bytes is looked up in half the time.
    every = np.zeros(256, dtype=np.int32)
    every[: len(table)] = table
    return np.asarray(cv2.LUT(labels.astype(np.uint8), every), dtype=np.int32)


def graded_depth(depth: FloatImage, foreground: Mask, camera: Intrinsics, config: JumpConfig) -> FloatImage:
    """Depth on a scale on which the largest step on one surface is 1; NaN where there is no foreground.

    That step is z tan(grazing) / f, plus noise that grows as z^2: z (a + b z) [m]. Its scale is the integral of
    dz / (z (a + b z)): ln(z / (a + b z)) / a.
    """
    a = np.float32(np.tan(config.grazing) / camera.fx)
    b = np.float32(config.sigmas * config.noise)
    # Every pixel, for that takes less time than to pick out the foreground; z / 0 makes the others NaN in the end.
    with np.errstate(divide="ignore", invalid="ignore"):
        graded: FloatImage = np.divide(depth, foreground, dtype=np.float32)
        graded /= a + b * graded
        np.log(graded, out=graded)
    graded /= a
    return graded


def surface_components(
    depth: FloatImage, foreground: Mask, camera: Intrinsics, config: JumpConfig
) -> tuple[int, Labels]:
    """Label the surfaces of the foreground.

    Of two neighbours across a jump the farther is taken out, so that the two sides no longer touch; what is left is
    labelled with 4-connectivity, and the pixels taken out then join the neighbour that is nearest to them in depth.

    Args:
        depth: (height, width) float32 [m], 0 = none.
        foreground: (height, width) bool.
        camera: its camera.
        config: when neighbours are apart.

    Returns:
        The number of labels, and (height, width) int32 labels: 0 = background, 1.. = surfaces.
    """
    graded = graded_depth(depth, foreground, camera, config)
    far = np.zeros(depth.shape, dtype=bool)
    for axis in (0, 1):
        near_side = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
        far_side = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
        step = graded[far_side] - graded[near_side]
        far[far_side] |= step > 1
        far[near_side] |= step < -1
    kept = foreground & ~far
    count, labels = cv2.connectedComponents(kept.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    return count - 1, regrow(np.asarray(labels, dtype=np.int32), graded, far)


def regrow(labels: Labels, graded: FloatImage, loose: Mask) -> Labels:
    """Give each loose pixel the label of the 4-neighbour nearest in depth, when no jump lies between them.

    Args:
        labels: (height, width) 0 = none; changed in place and returned.
        graded: (height, width) depth on a scale on which a jump is 1.
        loose: (height, width) bool.
    """
    at = np.flatnonzero(loose)
    if len(at) == 0:
        return labels
    height, width = graded.shape
    v, u = np.divmod(at, width)
    flat, depth = labels.ravel(), graded.ravel()
    own = depth[at]
    best = np.full(len(at), 1.0, dtype=np.float32)
    choice = np.zeros(len(at), dtype=np.int32)
    for off, exists in ((-width, v > 0), (width, v < height - 1), (-1, u > 0), (1, u < width - 1)):
        beside = np.where(exists, at + off, at)
        label = flat[beside]
        step = np.abs(depth[beside] - own)
        nearer = (label > 0) & (step <= best)
        best[nearer], choice[nearer] = step[nearer], label[nearer]
    flat[at] = choice
    return labels
