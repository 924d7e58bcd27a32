"""Open vessels whose thin bottom lies as low as the table: their rim is seen in pieces that lie on one circle."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage, RgbdFrame
from mbd_perception.quantile import median, quantile
from mbd_perception.segmentation.components import Labels
from mbd_perception.segmentation.table.plane import Plane

Points = NDArray[np.float64]
# About how many pixels of a piece are looked at.
SAMPLE = 150
RIDGE = 1e-15 * np.eye(3)


@dataclass(frozen=True)
class VesselConfig:
    """When pieces are one rim.

    Attributes:
        rim_height: their tops are equally high up to this share.
        rim: what is higher than this share of a piece's top is its rim.
        radius: smallest and largest of a rim [m].
        off: largest median distance of rim points from the circle [m], and as share of the radius.
        covered: share of the circle along which the rim is seen.
        sectors: into how many parts the circle is cut for that.
    """

    rim_height: float = 0.2
    rim: float = 0.75
    radius: tuple[float, float] = (0.02, 0.2)
    off: tuple[float, float] = (0.003, 0.05)
    covered: float = 0.6
    sectors: int = 24


@dataclass(frozen=True)
class _Piece:
    """One label: height of its top [m], its rim as (n, 2) points in the table's plane [m]."""

    label: int
    top: float
    rim: Points


def with_vessels_joined(
    labels: Labels, heights: FloatImage, frame: RgbdFrame, plane: Plane, config: VesselConfig
) -> Labels:
    """Labels in which the pieces of a vessel's rim, and what is seen within it, are one.

    Args:
        labels: (height, width) int32, 0 = none.
        heights: (height, width) float32 above the table [m].
        frame: what the camera saw, of the same size.
        plane: the table, optical frame.
        config: when pieces are one rim.
    """
    pieces = _pieces(labels, heights, frame, plane, config)
    joined = labels
    taken: set[int] = set()
    for one, other in combinations(pieces, 2):
        if one.label in taken or other.label in taken:
            continue
        if not _as_high(one.top, other.top, config):
            continue
        circle = _circle(one.rim, other.rim, config)
        if circle is None:
            continue
        taken |= {one.label, other.label}
        within = _seen_within(circle, max(one.top, other.top), frame, plane)
        joined = np.where(joined == other.label, one.label, joined)
        joined = np.where(within & (joined == 0) & (frame.depth > 0), one.label, joined).astype(np.int32)
    return joined


def _pieces(labels: Labels, heights: FloatImage, frame: RgbdFrame, plane: Plane, config: VesselConfig) -> list[_Piece]:
    """Every label that another is as high as, with its rim: what of it is nearly as high as its top."""
    samples = _samples(np.ascontiguousarray(labels[::2, ::2]))
    high = {number: heights[v, u] for number, v, u in samples}
    tops = {number: quantile(height, 0.95) for number, height in high.items()}
    columns, rows = frame.camera.rays()
    pieces = []
    for number, v, u in samples:
        top = tops[number]
        if not any(n != number and _as_high(top, other, config) for n, other in tops.items()):
            continue
        rim = high[number] >= config.rim * top
        if int(rim.sum()) < 6:
            continue
        down, across = v[rim], u[rim]
        z = frame.depth[down, across].astype(np.float64)
        points = np.stack([columns[0, across] * z, rows[down, 0] * z, z], axis=1) @ plane.axes.T
        pieces.append(_Piece(number, top, points))
    return pieces


def _samples(small: Labels) -> list[tuple[int, NDArray[np.intp], NDArray[np.intp]]]:
    """(label, v, u) of about ``SAMPLE`` pixels of each label of a picture at half size, counted at full size."""
    covered = np.flatnonzero(small != 0)
    label = small.ravel()[covered].astype(np.uint16)  # sorted faster than what is wider
    order = covered[np.argsort(label, kind="stable")]
    sizes = np.bincount(label)
    ends = np.cumsum(sizes)
    samples = []
    for number in np.flatnonzero(sizes).tolist():
        pixels = order[ends[number] - sizes[number] : ends[number]]
        v, u = np.divmod(pixels[:: max(1, len(pixels) // SAMPLE)], small.shape[1])
        samples.append((number, 2 * v, 2 * u))
    return samples


def _as_high(one: float, other: float, config: VesselConfig) -> bool:
    """Whether two tops [m] are those of one rim."""
    return abs(one - other) <= config.rim_height * max(one, other)


def _circle(one: Points, other: Points, config: VesselConfig) -> tuple[Points, float] | None:
    """(centre (2,), radius) [m] of the circle both rims lie on; None when there is none."""
    # Each of the two counts the same, however many of its points are looked at.
    weight = np.repeat([1.0 / len(one), 1.0 / len(other)], [len(one), len(other)])
    points = np.concatenate([one, other])
    middle = points.mean(axis=0)
    near = points - middle
    terms = np.column_stack([2 * near, np.ones(len(near))])
    weighted = terms.T * weight
    # Points on one line lie on no circle: with a little regularisation on one that is too large.
    fit = np.linalg.solve(weighted @ terms + RIDGE, weighted @ (near**2).sum(axis=1))
    radius = float(np.sqrt(max(fit[2] + fit[0] ** 2 + fit[1] ** 2, 0.0)))
    if not config.radius[0] <= radius <= config.radius[1]:
        return None
    spokes = near - fit[:2]
    off = np.abs(np.hypot(*spokes.T) - radius)
    limit = config.off[0] + config.off[1] * radius
    if max(median(off[: len(one)]), median(off[len(one) :])) > limit:
        return None
    angle = np.arctan2(spokes[:, 1], spokes[:, 0])[off < 2 * limit]
    seen = np.unique(((angle / (2 * np.pi) + 0.5) * config.sectors).astype(int) % config.sectors)
    return (middle + fit[:2], radius) if len(seen) >= config.covered * config.sectors else None


def _seen_within(circle: tuple[Points, float], height: float, frame: RgbdFrame, plane: Plane) -> NDArray[np.bool_]:
    """(height, width) bool; the pixels in which the inside of a rim of that height [m] is seen."""
    centre, radius = circle
    angle = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
    flat = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = flat @ plane.axes + (height - plane.offset) * plane.normal
    camera = frame.camera
    u = points[:, 0] / points[:, 2] * camera.fx + camera.cx
    v = points[:, 1] / points[:, 2] * camera.fy + camera.cy
    within = np.zeros(frame.depth.shape, dtype=np.uint8)
    cv2.fillPoly(within, [np.rint(np.stack([u, v], axis=1)).astype(np.int32)], 1)
    return within > 0
