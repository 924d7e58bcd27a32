"""The shape of a seam: two straight lines at a right angle, in the plane in which two boxes touch."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.components import Mask
from mbd_perception.segmentation.regions import SQUARE
from mbd_perception.segmentation.table.plane import Plane

Points = NDArray[np.float64]


@dataclass(frozen=True)
class SeamConfig:
    """When a border of colours is a seam between two objects.

    Attributes:
        apart: least difference of the chromaticities of the two sides: red and orange plastic differ by 0.2.
        alike: pixels within this of a side's chromaticity are of its colour.
        plain: share of the pixels that must be of one of the two colours.
        complete: share of a side's pixels that must hang together.
        dark: pixels whose R + G + B is less than this have no colour to speak of.
        least_share: of the pixels on the smaller side.
        thick: least thickness of a side across the plane of the seam [m].
        straight: rms distance of the seam from its plane and from its two lines [m], plus a std of depth noise.
        leg: least length of each of the two lines [m].
        around: so far from its plane [m] the faces it crosses are looked at.
        faces: share of what is seen there that must lie on them: not on a round thing.
        square: largest deviation of their angle from a right one, and of the plane from upright or level [rad].
    """

    apart: float = 0.12
    alike: float = 0.06
    plain: float = 0.9
    complete: float = 0.97
    dark: float = 90.0
    least_share: float = 0.15
    thick: float = 0.02
    straight: float = 0.002
    leg: float = 0.015
    around: float = 0.04
    faces: float = 0.85
    square: float = 0.26


def is_seam(part: RgbdFrame, sides: tuple[Mask, Mask], plane: Plane, noise: float, config: SeamConfig) -> bool:
    """Whether the border between two sides is one of two boxes that touch."""
    border = (cv2.dilate(sides[0].view(np.uint8), SQUARE) > 0) & sides[1] & (part.depth > 0)
    seam = _points(part, border)
    if len(seam) < 20:
        return False
    z = float(np.median(seam[:, 2]))
    tolerance = config.straight + noise * z * z
    middle = np.median(seam, axis=0)
    spread, axes = np.linalg.eigh(np.cov((seam - middle).T))
    normal = axes[:, 0]
    upright = abs(float(normal @ plane.normal))
    level_or_upright = upright < np.sin(config.square) or upright > np.cos(config.square)
    if np.sqrt(spread[0]) > tolerance or not level_or_upright:
        return False
    for one in sides:
        across = _points(part, one & (part.depth > 0)) @ normal
        if np.quantile(across, 0.95) - np.quantile(across, 0.05) < config.thick:
            return False
    lines = _two_lines((seam - middle) @ axes[:, 1:], tolerance, config)
    if lines is None:
        return False
    # Seen along the plane's normal the faces that the seam crosses are its two lines; a round thing is not.
    points = _points(part, (sides[0] | sides[1]) & (part.depth > 0)) - middle
    near = points[np.abs(points @ normal) < config.around]
    return lines.share_on(near @ axes[:, 1:], 2 * tolerance) >= config.faces


def _points(part: RgbdFrame, mask: Mask) -> Points:
    """(n, 3) points of the pixels of a mask [m, optical frame]."""
    x, y = part.camera.rays()
    v, u = np.nonzero(mask)
    z = part.depth[v, u]
    return np.stack([x[0, u] * z, y[v, 0] * z, z], axis=1).astype(np.float64)


@dataclass(frozen=True)
class Lines:
    """Two lines in the plane of a seam.

    Attributes:
        middles: (2, 2) a point of each [m].
        along: (2, 2) unit vector of each.
        low, high: (2,) least and largest coordinate of the seam along each [m].
    """

    middles: Points
    along: Points
    low: Points
    high: Points

    def share_on(self, flat: Points, tolerance: float) -> float:
        """Share of (n, 2) points [m] that lie on one of the lines, of those in the rectangle around the seam."""
        first = (flat - self.middles[0]) @ np.array([-self.along[0, 1], self.along[0, 0]])
        second = (flat - self.middles[1]) @ np.array([-self.along[1, 1], self.along[1, 0]])
        spans = flat @ self.along.T
        inside = ((spans >= self.low - tolerance) & (spans <= self.high + tolerance)).all(axis=1)
        on = np.minimum(np.abs(first), np.abs(second))[inside] <= tolerance
        return float(on.mean()) if len(on) else 0.0


def _two_lines(flat: Points, tolerance: float, config: SeamConfig) -> Lines | None:
    """The two lines that (n, 2) points [m] lie on when they meet at a right angle; None when it is one, or none."""
    best: tuple[float, NDArray[np.intp], NDArray[np.intp]] | None = None
    for turn in np.linspace(0.0, np.pi, 12, endpoint=False):
        order = np.argsort(flat @ np.array([np.cos(turn), np.sin(turn)]))
        for share in np.linspace(0.15, 0.85, 15):
            halves = np.split(order, [round(share * len(flat))])
            error = max(_line(flat[half])[0] for half in halves)
            if best is None or error < best[0]:
                best = (error, halves[0], halves[1])
    if best is None or best[0] > tolerance:
        return None
    legs = [flat[half] for half in best[1:]]
    along = np.stack([_line(leg)[1] for leg in legs])
    lengths = [float(np.ptp(np.quantile(leg @ way, [0.05, 0.95]))) for leg, way in zip(legs, along, strict=True)]
    if abs(float(along[0] @ along[1])) > np.sin(config.square) or min(lengths) < config.leg:
        return None
    spans = flat @ along.T
    return Lines(np.stack([leg.mean(axis=0) for leg in legs]), along, spans.min(axis=0), spans.max(axis=0))


def _line(flat: Points) -> tuple[float, Points]:
    """(rms distance [m], unit vector) of the line through (n, 2) points."""
    off = flat - flat.mean(axis=0)
    spread, axes = np.linalg.eigh(off.T @ off / len(off))
    return float(np.sqrt(max(spread[0], 0.0))), axes[:, 1]
