"""Organized connected components: pixels of one surface, told apart at jumps in depth (Trevor et al. 2013, sec. IV)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frame import DEPTH_NOISE, FloatImage, Intrinsics

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


def jump_threshold(depth: FloatImage, camera: Intrinsics, config: JumpConfig) -> FloatImage:
    """Largest step in depth [m] between neighbours on one surface: z tan(grazing) / f, plus noise that grows as z^2."""
    slope = np.float32(np.tan(config.grazing) / camera.fx)
    curve = np.float32(config.sigmas * config.noise)
    threshold: FloatImage = depth * (slope + curve * depth)
    return threshold


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
    threshold = jump_threshold(depth, camera, config)
    far = np.zeros(depth.shape, dtype=bool)
    for axis in (0, 1):
        near_side = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
        far_side = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
        step = depth[far_side] - depth[near_side]
        both = foreground[near_side] & foreground[far_side]
        far[far_side] |= both & (step > threshold[near_side])
        far[near_side] |= both & (step < -threshold[far_side])
    kept = foreground & ~far
    count, labels = cv2.connectedComponents(kept.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    return count - 1, regrow(np.asarray(labels, dtype=np.int32), depth, foreground & far, threshold)


def regrow(labels: Labels, depth: FloatImage, loose: Mask, threshold: FloatImage) -> Labels:
    """Give each loose pixel the label of the 4-neighbour nearest in depth, when that is within ``threshold`` [m]."""
    v, u = np.nonzero(loose)
    if len(v) == 0:
        return labels
    height, width = depth.shape
    best = np.full(len(v), np.inf, dtype=np.float32)
    choice = np.zeros(len(v), dtype=np.int32)
    for dv, du in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        nv, nu = np.clip(v + dv, 0, height - 1), np.clip(u + du, 0, width - 1)
        label = labels[nv, nu]
        step = np.where(label > 0, np.abs(depth[nv, nu] - depth[v, u]), np.inf)
        nearer = (step < best) & (step <= threshold[v, u])
        best[nearer], choice[nearer] = step[nearer], label[nearer]
    grown = labels.copy()
    grown[v, u] = choice
    return grown
