"""Other tables than the one that was chosen: beside it at the same height, higher, or a bench below."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose
from numpy.typing import NDArray

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.frames.units import HORIZON
from mbd_perception.segmentation.table.plane import Plane, PlaneConfig
from mbd_perception.segmentation.table.plane_search import STRIDE, find_planes, inverse_error

Coarse = NDArray[np.bool_]


@dataclass(frozen=True)
class BesideConfig:
    """What counts as a table beside the table.

    Attributes:
        least_area: smallest level surface in one piece, seen [m^2]: a stool; lids of things on the table are smaller.
        same_height: surfaces within this are at the same height [m].
        tilt: a surface is level within this angle to the table [rad].
        deepest: lower than this below the table is the floor [m].
        covers: a higher surface over more than this share of which the table would be is the lid of something on it.
    """

    least_area: float = 0.05
    same_height: float = 0.02
    tilt: float = 0.1
    deepest: float = 0.3
    covers: float = 0.5


@dataclass(frozen=True)
class TableBeside:
    """A level surface large enough to put things on, which is not the table.

    Attributes:
        higher: by how much it is above the table [m]; negative below.
        area: of what is seen of it [m^2].
        center: (x, y) of that [m, frame of the scene].
    """

    higher: float
    area: float
    center: tuple[float, float]

    @property
    def level(self) -> bool:
        """Whether it is as high as the table: what stands on it is then seen, too."""
        return abs(self.higher) < BesideConfig.same_height

    def describe(self, table: tuple[float, float]) -> str:
        """In words, seen from the table's ``(x, y)`` [m, frame of the scene]."""
        away, aside = self.center[0] - table[0], self.center[1] - table[1]
        side = ("to the left" if aside > 0 else "to the right") if abs(aside) > abs(away) else ""
        side = side or ("behind it" if away > 0 else "before it")
        height = f"{abs(self.higher):.2f} m {'higher' if self.higher > 0 else 'lower'}"
        return f"{side}, {'at the same height' if self.level else height}, {self.area:.2f} m^2 seen"


@dataclass(frozen=True)
class TablesInView:
    """The table and others.

    Attributes:
        center: (x, y) of what is seen of the table [m, frame of the scene].
        others: tables beside it, the largest first.
    """

    center: tuple[float, float]
    others: tuple[TableBeside, ...]

    @property
    def hint(self) -> str:
        """One sentence for people; empty when there is one table only."""
        if not self.others:
            return ""
        named = "; ".join(other.describe(self.center) for other in self.others)
        count = "another table is" if len(self.others) == 1 else f"{len(self.others)} other tables are"
        apart = [other for other in self.others if not other.level]
        seen = "what stands there counts, too" if not apart else "what stands higher or lower is left out"
        return f"{count} in view ({named}): {seen}"


def tables_beside(
    frame: RgbdFrame, table: Plane, noise: float, pose: CameraPose, config: BesideConfig | None = None
) -> TablesInView:
    """The table, and other tables in a frame.

    Args:
        frame: what the camera saw.
        table: the table that was chosen, optical frame.
        noise: std of inverse depth [1/m] on it.
        pose: of the camera in the frame of the scene.
        config: what counts.
    """
    config = config or BesideConfig()
    depth, camera = frame.depth, frame.camera
    own = _level(frame, table, noise)
    # A shadow, in which nothing is seen, does not part a table; where something lower is seen it ends.
    joined = (inverse_error(depth, camera, table) > -4 * noise) | (depth[::STRIDE, ::STRIDE] <= 0)
    pieces = _pieces(own, joined, _covered(frame, table))
    if not pieces:
        return TablesInView((0.0, 0.0), ())
    main, *rest = pieces
    found = [TableBeside(0.0, a, _center(frame, piece, pose)) for piece, a in rest if a >= config.least_area]
    hull = _hull(main[0])
    for candidate in find_planes(depth, camera, PlaneConfig(noise=noise, max_tilt=config.tilt), table.normal):
        level = _level(frame, candidate.plane, noise) & ~own
        for piece, area in _pieces(level, level, _covered(frame, candidate.plane))[:1]:
            higher = float(np.mean(_heights(frame, table)[piece]))
            if area < config.least_area or abs(higher) < config.same_height or higher < -config.deepest:
                continue
            if higher < 0 or float(hull[piece].mean()) <= config.covers:
                found.append(TableBeside(higher, area, _center(frame, piece, pose)))
    return TablesInView(_center(frame, main[0], pose), tuple(sorted(found, key=lambda t: -t.area)))


def _level(frame: RgbdFrame, plane: Plane, noise: float) -> Coarse:
    """Coarse pixels that lie in a plane together with their neighbours: a wall passes its height in a thin band."""
    small = frame.depth[::STRIDE, ::STRIDE]
    near = (np.abs(inverse_error(frame.depth, frame.camera, plane)) < 4 * noise) & (small > 0)
    opened = cv2.morphologyEx(near.view(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return np.asarray(opened > 0)


def _heights(frame: RgbdFrame, table: Plane) -> NDArray[np.float32]:
    """Heights of the coarse pixels above the table [m]."""
    x, y = frame.camera.rays()
    normal = table.normal.astype(np.float32)
    slant = normal[0] * x[:, ::STRIDE] + (normal[1] * y[::STRIDE] + normal[2])
    return np.asarray(slant * frame.depth[::STRIDE, ::STRIDE] + table.offset, dtype=np.float32)


def _covered(frame: RgbdFrame, plane: Plane) -> NDArray[np.float32]:
    """Area of a plane [m^2] that each coarse pixel covers."""
    x, y = frame.camera.rays()
    normal = plane.normal.astype(np.float32)
    slant = -(normal[0] * x[:, ::STRIDE] + (normal[1] * y[::STRIDE] + normal[2]))
    small = np.minimum(frame.depth[::STRIDE, ::STRIDE], np.float32(HORIZON))
    area = STRIDE**2 * small**2 / (np.maximum(slant, 0.05) * frame.camera.fx * frame.camera.fy)
    return np.asarray(area, dtype=np.float32)


def _pieces(level: Coarse, joined: Coarse, covered: NDArray[np.float32]) -> list[tuple[Coarse, float]]:
    """Level pixels in pieces, the largest first, with their areas [m^2]; ``joined`` says what holds pieces together."""
    count, labels = cv2.connectedComponents((joined | level).view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    areas = np.bincount(labels[level], weights=covered[level], minlength=count)
    order = [int(k) for k in np.argsort(-areas, kind="stable") if areas[k] > 0]
    return [(level & (labels == k), float(areas[k])) for k in order]


def _hull(piece: Coarse) -> Coarse:
    """Coarse pixels within the convex outline of a piece."""
    v, u = np.nonzero(piece)
    filled = np.zeros(piece.shape, dtype=np.uint8)
    cv2.fillConvexPoly(filled, cv2.convexHull(np.stack([u, v], axis=1).astype(np.int32)), 1)
    return filled > 0


def _center(frame: RgbdFrame, piece: Coarse, pose: CameraPose) -> tuple[float, float]:
    """Mean (x, y) [m, frame of the scene] of the points of a piece."""
    camera: Intrinsics = frame.camera
    columns, rows = camera.rays()
    v, u = np.nonzero(piece)
    z = frame.depth[::STRIDE, ::STRIDE][v, u].astype(np.float64)
    points = pose.to_base(np.stack([columns[0, u * STRIDE] * z, rows[v * STRIDE, 0] * z, z], axis=1))
    return float(points[:, 0].mean()), float(points[:, 1].mean())
