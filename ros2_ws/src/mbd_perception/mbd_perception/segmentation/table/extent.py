"""How far the table reaches: what rises beyond its edge (a wall, a chair, a person) stands on something else."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage
from mbd_perception.frames.units import HORIZON
from mbd_perception.segmentation.components import Labels, Mask, renumbered
from mbd_perception.segmentation.hull import inside_hull
from mbd_perception.segmentation.table.plane import Plane

# Every fourth pixel of every fourth row is enough for an outline.
STRIDE = 4


@dataclass(frozen=True)
class ExtentConfig:
    """What counts as above the table.

    Attributes:
        margin: this much of the edge [m] does not count: a wall at the edge rises there.
        sigmas: nor does that many std of depth noise: the foot of a wall lies in the plane of the table up to there.
        piece: what is at the height of the table and has this share of its largest piece is a table too.
        beyond: where the table leaves the picture it is taken to go on by this share of the picture.
        mostly: a surface with this share of its pixels above the table is kept complete.
        foot: of a surface that is kept in part, something is nearer to the table than this [m].
        hardly: of a surface with less than this share above the table nothing is kept.
    """

    margin: float = 0.01
    sigmas: float = 5.0
    piece: float = 0.25
    beyond: float = 0.25
    mostly: float = 0.5
    hardly: float = 0.1
    foot: float = 0.05


@dataclass(frozen=True)
class TableOutline:
    """The convex outline of a table.

    Attributes:
        axes: (2, 3) two directions in the plane, optical frame.
        corners: (k, 2) along the axes [m], in cyclic order.
        noise: std of inverse depth [1/m] on the table.
    """

    axes: NDArray[np.float64]
    corners: NDArray[np.float64]
    noise: float

    def inside(self, points: NDArray[np.float64], margin: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which (n, 3) points [m, optical frame] lie above the outline, each its (n,) margin [m] from the far edges.

        Far edges face away from the camera: only there is it seen where a wall meets the table. At a near edge the
        margin would cost what stands there its front.
        """
        return inside_hull(points @ self.axes.T, self.corners, margin, seen_from=np.zeros(2))


def table_outline(
    depth: FloatImage, camera: Intrinsics, plane: Plane, noise: float, config: ExtentConfig
) -> TableOutline | None:
    """The outline of the table from the pixels that lie in its plane; None when there are hardly any.

    Where the table leaves the picture nobody sees its edge: there it is continued beyond the picture.
    """
    small = np.ascontiguousarray(depth[::STRIDE, ::STRIDE])
    x, y = (r.astype(np.float64) for r in _rays(camera))
    w = -(plane.normal[0] * x + (plane.normal[1] * y + plane.normal[2])) / plane.offset
    error = np.where(small > 0, 1 / np.maximum(small, 1e-3) - w, -np.inf)
    flat = _spread_out(np.abs(error) < 4 * noise, small > 0, 8 * noise * plane.offset * camera.fy / STRIDE)
    # What stands on the table may cut it in pieces. A table at the same height beside it is part of it: nothing that
    # stands there is lost, and that there are two is said (``tables_beside``).
    count, patches = cv2.connectedComponents((error > -4 * noise).view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    pixels = np.bincount(patches[flat], minlength=count)
    if pixels.max() < 20:
        return None
    table = flat & (pixels >= config.piece * pixels.max())[patches]
    # The first and last pixel of each row are enough for a convex outline.
    v = np.flatnonzero(table.any(axis=1))
    first, last = table[v].argmax(axis=1), table.shape[1] - 1 - table[v, ::-1].argmax(axis=1)
    v, u = np.concatenate([v, v]), np.concatenate([first, last])
    hull = cv2.convexHull(np.stack([u, v], axis=1).astype(np.int32))[:, 0].astype(np.float64)
    corners = np.concatenate([hull, _continued(u, v, small.shape, config.beyond)])
    columns = (corners[:, 0] * STRIDE - camera.cx) / camera.fx
    rows = (corners[:, 1] * STRIDE - camera.cy) / camera.fy
    rays = np.stack([columns, rows, np.ones(len(rows))], axis=1)
    inverse = -(rays @ plane.normal) / plane.offset
    near = inverse > 1 / HORIZON  # farther away the plane is no table
    if near.sum() < 3:
        return None
    rays, inverse = rays[near], inverse[near]
    ground = (rays / inverse[:, None]) @ plane.axes.T
    outline = cv2.convexHull(ground.astype(np.float32))[:, 0].astype(np.float64)
    return TableOutline(plane.axes, outline, noise)


def _spread_out(near: Mask, valid: Mask, band: float) -> Mask:
    """Of the pixels near the plane those that lie in it with what is below or above them.

    Where a wall or a chair passes the height of the table, a band of its pixels, ``band`` rows high, is near the plane
    too. Shares of the valid pixels, so that missing ones do no harm.
    """
    counts = [cv2.boxFilter(m.view(np.uint8), cv2.CV_16S, (3, 3), normalize=False) for m in (near, valid)]
    kept: Mask = near & (4 * counts[0] >= 3 * counts[1])
    rows = 2 * int(np.ceil(band)) + 2
    spread = np.zeros(near.shape, dtype=bool)
    for anchor in (0, rows - 1):
        lying, seen = (
            cv2.boxFilter(m.view(np.uint8), cv2.CV_16S, (1, rows), anchor=(0, anchor), normalize=False,
                          borderType=cv2.BORDER_REPLICATE)
            for m in (near, valid)
        )  # fmt: skip
        spread |= 10 * lying >= 7 * seen
    kept &= spread
    return kept


def _rays(camera: Intrinsics) -> tuple[FloatImage, FloatImage]:
    """Rays of every fourth pixel."""
    x, y = camera.rays()
    return x[:, ::STRIDE], y[::STRIDE]


def _continued(u: NDArray[np.intp], v: NDArray[np.intp], shape: tuple[int, ...], beyond: float) -> NDArray[np.float64]:
    """(k, 2) points (u, v) outside the picture, where the table leaves it below, left and right."""
    height, width = shape
    points: list[tuple[float, float]] = []
    edge = 2
    below = v >= height - edge
    if below.any():
        points += [(float(u[below].min()), (1 + beyond) * height), (float(u[below].max()), (1 + beyond) * height)]
    for touching, border, way in ((u >= width - edge, width - 1, 1), (u < edge, 0, -1)):
        if touching.any():
            far, near = float(v[touching].min()), float(v[touching].max())
            reach = beyond * width
            # The far edge of the table goes on as it ran before it left the picture.
            before = (v < far) & (np.abs(u - border) <= reach)
            drop = (far - v[before]) / np.maximum(np.abs(u[before] - border), 1)
            goes_on = far + reach * float(np.median(drop)) if before.sum() >= edge else 0.5 * (far + near)
            points += [(border + way * reach, min(max(goes_on, far), near)), (border + way * reach, near)]
    return np.array(points).reshape(-1, 2)


def above_table(
    surfaces: Labels,
    heights: FloatImage,
    depth: FloatImage,
    camera: Intrinsics,
    *,
    outline: TableOutline,
    config: ExtentConfig,
) -> Labels:
    """Surfaces without what does not stand on the table.

    A surface that is mostly above the table stays complete; of another, what is above the table stays, unless that is
    hardly any of it or does not come down to the table: a wall, and not what leans on it.
    """
    count = int(surfaces.max(initial=0))
    small = np.ascontiguousarray(surfaces[::STRIDE, ::STRIDE])
    v, u = np.nonzero(small != 0)
    if len(v) == 0:
        return surfaces
    x, y = _rays(camera)
    z = depth[::STRIDE, ::STRIDE][v, u]
    points = np.stack([x[0, u] * z, y[v, 0] * z, z], axis=1).astype(np.float64)
    inside = outline.inside(points, config.margin + config.sigmas * outline.noise * points[:, 2] ** 2)
    label = small[v, u]
    total = np.bincount(label, minlength=count + 1)
    share = np.bincount(label, weights=inside, minlength=count + 1) / np.maximum(total, 1)
    # A surface too small to be met by the coarse grid is left to the other filters.
    complete = (share >= config.mostly) | (total == 0)
    if complete[1:].all():
        return surfaces
    lowest = np.full(count + 1, np.inf)
    np.minimum.at(lowest, label[inside], heights[::STRIDE, ::STRIDE][v, u][inside])
    partly = ~complete & (share >= config.hardly) & (lowest < config.foot)
    kept = renumbered(surfaces, np.where(complete, np.arange(count + 1), 0))
    if partly.any():
        mask: Mask = np.zeros(small.shape, dtype=bool)
        mask[v, u] = inside & partly[label]
        large = np.repeat(np.repeat(mask, STRIDE, axis=0), STRIDE, axis=1)[: surfaces.shape[0], : surfaces.shape[1]]
        kept = np.where(large & partly.take(surfaces), surfaces, kept)
    return kept
