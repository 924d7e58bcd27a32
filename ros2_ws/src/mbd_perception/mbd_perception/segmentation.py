"""From a frame to the table and a label picture of what stands on it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from mbd_model.errors import MbdError

from mbd_perception.components import JumpConfig, Labels, Mask, surface_components
from mbd_perception.frame import FloatImage, RgbdFrame
from mbd_perception.plane import Plane, PlaneConfig, supporting_plane
from mbd_perception.pose import CameraPose
from mbd_perception.regions import SQUARE
from mbd_perception.separation import SeparationConfig, separate

Range = tuple[float, float]
EVERYWHERE: Range = (-math.inf, math.inf)


@dataclass(frozen=True)
class Workspace:
    """Where objects can be [m, base frame]; what reaches out of it (the arm, a person) is not an object.

    Attributes:
        x, y, z: (lowest, highest) coordinate.
    """

    x: Range = EVERYWHERE
    y: Range = EVERYWHERE
    z: Range = EVERYWHERE

    def __post_init__(self) -> None:
        """Raises MbdError for an empty range."""
        for name in ("x", "y", "z"):
            low, high = getattr(self, name)
            if not low < high:
                raise MbdError(f"workspace {name} from {low} to {high} m is empty: give the lower number first")

    def contains(self, depth: FloatImage, frame: RgbdFrame, pose: CameraPose) -> Mask:
        """Which pixels with depth lie inside, (height, width) bool."""
        inside = depth > 0
        columns, rows = frame.camera.rays()
        for axis, (low, high) in enumerate((self.x, self.y, self.z)):
            if (low, high) == EVERYWHERE:
                continue
            a, b, c = pose.rotation[axis].astype(np.float32)
            coordinate = a * columns + (b * rows + c)
            coordinate *= depth
            offset = np.float32(pose.position[axis])
            inside &= (coordinate > np.float32(low) - offset) & (coordinate < np.float32(high) - offset)
        return inside


@dataclass(frozen=True)
class SegmentationConfig:
    """How objects are told from table, from noise and from each other.

    Attributes:
        plane: the search for the table.
        jump: when neighbouring pixels are different surfaces.
        separation: how touching objects are told apart.
        workspace: where objects can be.
        min_height: lowest height above the table of an object's surface [m].
        height_sigmas: that many std of depth noise are not an object either.
        min_rise: mean height of an object over the least height that noise allows.
        min_area: smallest visible surface of an object [m^2]: about a thumbnail.
        min_pixels: fewer pixels than this are noise whatever their size.
        max_outside: largest share of an object's pixels outside the workspace.
    """

    plane: PlaneConfig = field(default_factory=PlaneConfig)
    jump: JumpConfig = field(default_factory=JumpConfig)
    separation: SeparationConfig = field(default_factory=SeparationConfig)
    workspace: Workspace = field(default_factory=Workspace)
    min_height: float = 0.006
    height_sigmas: float = 3.0
    min_rise: float = 1.25
    min_area: float = 2.0e-4
    min_pixels: int = 30
    max_outside: float = 0.05


@dataclass(frozen=True)
class Segmentation:
    """What was found in one frame.

    Attributes:
        plane: the table, optical frame.
        labels: (height, width) int32; 0 = no object, 1..count.
        count: number of objects.
        heights: (height, width) float32 above the table [m].
        left_out: surfaces above the table that reach out of the workspace.
        noise: std of inverse depth [1/m] as measured on the table in this very frame.
    """

    plane: Plane
    labels: Labels
    count: int
    heights: FloatImage
    left_out: int
    noise: float


def segment(frame: RgbdFrame, pose: CameraPose | None, config: SegmentationConfig) -> Segmentation:
    """Find the table and what stands on it.

    Args:
        frame: what the camera saw.
        pose: where the camera stands in the base frame; None when not known: then the workspace is not applied.
        config: thresholds.

    Raises:
        NoTableError: no supporting plane in view.
    """
    depth = frame.depth
    inside = depth > 0 if pose is None else config.workspace.contains(depth, frame, pose)
    near_table = np.where(inside, depth, np.float32(0))
    up = None if pose is None else pose.up_in_camera
    plane = supporting_plane(near_table, frame.camera, config.plane, up)
    heights = plane.height(depth, frame.camera)
    noise = measured_noise(near_table, heights, plane, config.jump.noise)
    least = np.float32(config.height_sigmas * noise * plane.offset) * depth
    least = np.maximum(np.float32(config.min_height), least)
    foreground = (heights > least) & (depth > 0)
    count, surfaces = surface_components(depth, foreground, frame.camera, config.jump)
    surfaces = _without_noise(surfaces, count, heights, least, config)
    objects = separate(
        frame,
        surfaces,
        heights,
        (depth > 0) & ~foreground,
        noise=noise,
        jump=config.jump,
        config=config.separation,
    )
    objects = fill_holes(objects, depth)
    numbers, left_out = _object_numbers(frame, objects, inside, config)
    return Segmentation(
        plane=plane,
        labels=numbers[objects],
        count=int(numbers.max(initial=0)),
        heights=heights,
        left_out=left_out,
        noise=noise,
    )


def measured_noise(depth: FloatImage, heights: FloatImage, plane: Plane, expected: float) -> float:
    """Std of inverse depth [1/m] on the table of this frame, from the median error.

    A height error h at depth z is an error h / (z offset) of inverse depth; 6 times ``expected`` is no table.
    """
    sample = depth[::4, ::4]
    error = np.abs(heights[::4, ::4]) / np.where(sample > 0, sample * np.float32(plane.offset), np.float32(1e-9))
    table = error[(sample > 0) & (error < 6 * expected)]
    return 1.4826 * float(np.median(table)) if table.size else expected


def _without_noise(
    surfaces: Labels, count: int, heights: FloatImage, least: FloatImage, config: SegmentationConfig
) -> Labels:
    """Drop specks, and films that hardly rise above the least height: bumps of a table that is not quite flat."""
    flat = surfaces.ravel()
    covered = np.flatnonzero(flat)
    label = flat[covered]
    pixels = np.bincount(label, minlength=count + 1)
    rise = np.bincount(label, weights=heights.ravel()[covered] / least.ravel()[covered], minlength=count + 1)
    keep = (pixels >= config.min_pixels) & (rise >= config.min_rise * pixels)
    kept = flat.copy()
    kept[covered[~keep[label]]] = 0
    return kept.reshape(surfaces.shape)


def fill_holes(objects: Labels, depth: FloatImage) -> Labels:
    """Give an object the patches that it alone surrounds: the bottom of a bowl that is as low as the table."""
    empty = (objects == 0).astype(np.uint8)
    _, patches, stats, _ = cv2.connectedComponentsWithStats(empty, connectivity=4, ltype=cv2.CV_32S)
    height, width = objects.shape
    x, y, w, h = (stats[:, i] for i in (cv2.CC_STAT_LEFT, cv2.CC_STAT_TOP, cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT))
    closed = (x > 0) & (y > 0) & (x + w < width) & (y + h < height)
    closed[0] = False
    if not closed.any():
        return objects
    filled = objects.copy()
    for patch in np.flatnonzero(closed):
        window = (slice(y[patch] - 1, y[patch] + h[patch] + 1), slice(x[patch] - 1, x[patch] + w[patch] + 1))
        hole = patches[window] == patch
        rim = cv2.dilate(hole.astype(np.uint8), SQUARE).astype(bool) & ~hole
        around = np.unique(objects[window][rim])
        around = around[around > 0]
        if len(around) == 1:
            filled[window][hole & (depth[window] > 0)] = around[0]
    return filled


def _object_numbers(frame: RgbdFrame, objects: Labels, inside: Mask, config: SegmentationConfig) -> tuple[Labels, int]:
    """Number the objects from 1; what is too small or reaches out of the workspace gets 0.

    Returns:
        New number of each old one, and how many large ones reach out of the workspace.
    """
    flat = objects.ravel()
    covered = np.flatnonzero(flat)
    label = flat[covered]
    pixels = np.bincount(label, minlength=1)
    side = frame.depth.ravel()[covered].astype(np.float64)
    area = np.bincount(label, weights=side * side, minlength=1) / (frame.camera.fx * frame.camera.fy)
    outside = np.bincount(label, weights=~inside.ravel()[covered], minlength=1)
    large = (pixels >= config.min_pixels) & (area >= config.min_area)
    reaching = outside > config.max_outside * pixels
    keep = np.flatnonzero(large & ~reaching)
    numbers = np.zeros(len(pixels), dtype=np.int32)
    numbers[keep] = np.arange(1, len(keep) + 1)
    return numbers, int((large & reaching).sum())
