"""From a frame to the table and a label picture of what stands on it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose

from mbd_perception.frames.frame import FloatImage, RgbdFrame
from mbd_perception.segmentation.components import JumpConfig, Labels, Mask, surface_components
from mbd_perception.segmentation.gaps import with_gaps_closed
from mbd_perception.segmentation.holes import enclosed_patches, fill_holes
from mbd_perception.segmentation.joining.vessels import VesselConfig, with_vessels_joined
from mbd_perception.segmentation.seam_shape import SeamConfig
from mbd_perception.segmentation.seams import split_at_seams
from mbd_perception.segmentation.separation import SeparationConfig, separate
from mbd_perception.segmentation.table.choice import FoundTable, find_table
from mbd_perception.segmentation.table.extent import ExtentConfig, TableOutline, above_table, table_outline
from mbd_perception.segmentation.table.noise import settled
from mbd_perception.segmentation.table.orientation import quarter_turns, turned_frame, turned_plane
from mbd_perception.segmentation.table.plane import Plane, PlaneConfig
from mbd_perception.segmentation.table.walls import before_walls, without_hanging
from mbd_perception.segmentation.workspace import Workspace

__all__ = ["Segmentation", "SegmentationConfig", "TableTop", "Workspace", "find_surfaces", "segment"]


@dataclass(frozen=True)
class SegmentationConfig:
    """How objects are distinguished from table, from noise and from each other.

    Attributes:
        plane: the search for the table.
        jump: when neighbouring pixels are different surfaces.
        separation: how touching objects are separated.
        seam: when things that stand flush are separated by their colours.
        vessel: when pieces are the rim of one open vessel.
        extent: what counts as above the table.
        workspace: where objects can be.
        min_height: lowest height above the table of an object's surface [m].
        height_sigmas: that many std of depth noise are not an object either.
        min_rise: mean height of an object over the least height that noise allows.
        bumpy: with noise of more than that many times the expected one, ``min_rise`` and what a sharp crease is grow,
            up to twofold.
        min_area: smallest visible surface of an object [m^2]: about a thumbnail.
        min_pixels: fewer pixels than this are noise whatever their size.
        max_outside: largest share of an object's pixels outside the workspace.
    """

    plane: PlaneConfig = field(default_factory=PlaneConfig)
    jump: JumpConfig = field(default_factory=JumpConfig)
    separation: SeparationConfig = field(default_factory=SeparationConfig)
    seam: SeamConfig = field(default_factory=SeamConfig)
    vessel: VesselConfig = field(default_factory=VesselConfig)
    extent: ExtentConfig = field(default_factory=ExtentConfig)
    workspace: Workspace = field(default_factory=Workspace)
    min_height: float = 0.006
    height_sigmas: float = 3.0
    min_rise: float = 1.25
    bumpy: float = 3.0
    min_area: float = 2.0e-4
    min_pixels: int = 30
    max_outside: float = 0.05


@dataclass(frozen=True)
class TableTop:
    """What objects stand on.

    Attributes:
        plane: its plane, optical frame.
        outline: how far it reaches; None when not known.
        noise: std of inverse depth [1/m] as measured on it.
        walls: planes that end it.
    """

    plane: Plane
    outline: TableOutline | None
    noise: float
    walls: tuple[Plane, ...] = ()


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


def segment(
    frame: RgbdFrame, pose: CameraPose | None, config: SegmentationConfig, last: Plane | None = None
) -> Segmentation:
    """Find the table and what stands on it.

    Args:
        frame: what the camera saw.
        pose: where the camera stands in the base frame; None when not known: then the workspace is not applied.
        config: thresholds.
        last: the table in the last frame of the same camera; None when there is none.

    Raises:
        NoTableError: no supporting plane in view.
    """
    inside = None if pose is None else config.workspace.contains(frame.depth, frame, pose)
    near_table = frame.depth if inside is None else np.where(inside, frame.depth, np.float32(0))
    up = None if pose is None else pose.up_in_camera
    table = find_table(near_table, frame.camera, config.plane, up, last=last)
    turns = quarter_turns(table.plane.normal)
    if turns == 0:
        return _segment_upright(frame, inside, table, config)
    found = _segment_upright(
        turned_frame(frame, turns),
        None if inside is None else np.rot90(inside, turns),
        FoundTable(turned_plane(table.plane, turns), table.noise, tuple(turned_plane(w, turns) for w in table.walls)),
        config,
    )
    plane = turned_plane(found.plane, -turns)
    labels = np.ascontiguousarray(np.rot90(found.labels, -turns))
    heights = np.ascontiguousarray(np.rot90(found.heights, -turns))
    return replace(found, plane=plane, labels=labels, heights=heights)


def _segment_upright(
    frame: RgbdFrame, inside: Mask | None, table: FoundTable, config: SegmentationConfig
) -> Segmentation:
    """What stands on a table that is level in the picture; ``inside``: which pixels lie in the workspace."""
    near_table = frame.depth if inside is None else np.where(inside, frame.depth, np.float32(0))
    plane, noise = settled(near_table, frame.camera, table.plane, table.noise)
    config = _for_noise(config, table.noise, noise)
    outline = table_outline(frame.depth, frame.camera, plane, min(noise, 3 * table.noise), config.extent)
    labels = np.zeros(frame.depth.shape, dtype=np.int32)
    heights = np.zeros(frame.depth.shape, dtype=np.float32)
    top, left, height, width = rising_window(frame, plane, config)
    if height == 0 or width == 0:
        return Segmentation(plane, labels, 0, heights, 0, noise)
    part = frame.window(top, left, height, width)
    seen = part.depth > 0
    part = replace(part, depth=with_gaps_closed(part.depth, noise))
    window = (slice(top, top + height), slice(left, left + width))
    heights[window] = plane.height(part.depth, part.camera)
    surfaces, flat = find_surfaces(part, heights[window], TableTop(plane, outline, noise, table.walls), config)
    if not surfaces.any():
        return Segmentation(plane, labels, 0, heights, 0, noise)
    # The bottom of a bowl that is as low as the table would take its rim apart.
    holes = enclosed_patches(surfaces, part.depth)
    surfaces = fill_holes(surfaces, holes)
    found = separate(part, surfaces, heights[window], flat, noise=noise, jump=config.jump, config=config.separation)
    whole = with_vessels_joined(fill_holes(found.objects, holes), heights[window], part, plane, config.vessel)
    objects = split_at_seams(part, whole, plane, noise, config.seam)
    # A closed gap is nowhere, so it is not outside either.
    numbers, left_out = _object_numbers(part, objects, None if inside is None else inside[window] | ~seen, config)
    # A pixel without depth is no part of what is measured, closed or enclosed as it may be.
    labels[window] = numbers[objects] * seen
    return Segmentation(plane, labels, int(numbers.max(initial=0)), heights, left_out, noise)


def _for_noise(config: SegmentationConfig, expected: float, noise: float) -> SegmentationConfig:
    """The thresholds for a table on which inverse depth errs by ``noise`` where ``expected`` was reckoned with [1/m].

    A camera noisier than expected has steps that are no jumps, and makes bumps, whose slopes are no creases: its noise
    is not independent from pixel to pixel.
    """
    bumpy = min(max(noise / (config.bumpy * config.plane.noise), 1.0), 2.0)
    merge = replace(config.separation.merge, sharp=bumpy * config.separation.merge.sharp)
    return replace(
        config,
        jump=replace(config.jump, noise=max(config.jump.noise, expected)),
        separation=replace(config.separation, merge=merge),
        min_rise=bumpy * config.min_rise,
    )


def rising_window(frame: RgbdFrame, plane: Plane, config: SegmentationConfig) -> tuple[int, int, int, int]:
    """(top, left, height, width) [px] of the part of the picture in which anything rises above the table.

    Found on every fourth pixel of every fourth row, with a margin; the corner is even, for the picture at half size.
    """
    camera = frame.camera
    sample = np.ascontiguousarray(frame.depth[::4, ::4])
    coarse = Intrinsics(camera.fx / 4, camera.fy / 4, camera.cx / 4, camera.cy / 4, sample.shape[1], sample.shape[0])
    rising = (plane.height(sample, coarse) > 0.5 * config.min_height) & (sample > 0)
    # Noise rises here and there: only what covers a square of 12 pixels at least in part is looked at.
    solid = cv2.boxFilter(rising.view(np.uint8), -1, (3, 3), normalize=False) >= 5
    x, y, width, height = cv2.boundingRect(solid.view(np.uint8))
    if width == 0:
        return 0, 0, 0, 0
    margin = 16
    top, left = max(4 * y - margin, 0), max(4 * x - margin, 0)
    bottom, right = min(4 * (y + height) + margin, camera.height), min(4 * (x + width) + margin, camera.width)
    return top, left, bottom - top, right - left


def find_surfaces(
    frame: RgbdFrame, heights: FloatImage, table: TableTop, config: SegmentationConfig
) -> tuple[Labels, Mask]:
    """What rises above the table.

    Returns:
        (height, width) int32 surfaces, 0 = none, and (height, width) bool pixels with depth that do not rise.
    """
    depth = frame.depth
    least = depth * np.float32(config.height_sigmas * table.noise * table.plane.offset)
    np.maximum(least, np.float32(config.min_height), out=least)
    foreground = (heights > least) & (depth > 0)
    wall: Mask | None = None
    if table.walls:
        wall = foreground & ~before_walls(depth, frame.camera, table.walls, table.noise)
        foreground &= ~wall
    count, surfaces = surface_components(depth, foreground, frame.camera, config.jump)
    if wall is not None:
        surfaces = without_hanging(surfaces, wall)
    surfaces = _without_noise(surfaces, count, heights, least, config)
    if table.outline is not None:
        surfaces = above_table(surfaces, heights, depth, frame.camera, outline=table.outline, config=config.extent)
    return surfaces, (depth > 0) & ~foreground


def _without_noise(
    surfaces: Labels, count: int, heights: FloatImage, least: FloatImage, config: SegmentationConfig
) -> Labels:
    """Drop specks, and films that hardly rise above the least height: bumps of a table that is not quite flat."""
    # Every second pixel of every second row is enough for a mean.
    label, rises = surfaces[::2, ::2], heights[::2, ::2] / least[::2, ::2]
    covered = label > 0
    label = label[covered]
    pixels = np.bincount(label, minlength=count + 1)
    rise = np.bincount(label, weights=rises[covered], minlength=count + 1)
    keep = (4 * pixels >= config.min_pixels) & (rise >= config.min_rise * pixels)
    return np.where(keep, np.arange(count + 1), 0).astype(np.int32)[surfaces]


def _object_numbers(
    frame: RgbdFrame, objects: Labels, inside: Mask | None, config: SegmentationConfig
) -> tuple[Labels, int]:
    """Number the objects from 1; what is too small or reaches out of the workspace gets 0.

    Returns:
        New number of each old one, and how many large ones reach out of the workspace.
    """
    last = int(objects.max(initial=0)) + 1
    # Every second row will do.
    covered = objects[::2] > 0
    label = objects[::2][covered]
    pixels = 2 * np.bincount(label, minlength=last)
    z = frame.depth[::2][covered]
    area = 2 * np.bincount(label, weights=z * z, minlength=last) / (frame.camera.fx * frame.camera.fy)
    large = (pixels >= config.min_pixels) & (area >= config.min_area)
    reaching = np.zeros(len(pixels), dtype=bool)
    if inside is not None:
        outside = 2 * np.bincount(label, weights=~inside[::2][covered], minlength=last)
        reaching = outside > config.max_outside * pixels
    keep = np.flatnonzero(large & ~reaching)
    numbers = np.zeros(len(pixels), dtype=np.int32)
    numbers[keep] = np.arange(1, len(keep) + 1)
    return numbers, int((large & reaching).sum())
