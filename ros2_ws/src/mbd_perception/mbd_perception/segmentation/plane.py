"""The supporting plane of a depth image, found in inverse depth.

A plane is linear in inverse depth: w = 1/z = A x' + B y' + C over the rays x' = x/z, y' = y/z. A structured-light
camera measures disparity, so the noise of w is the same everywhere in the picture, and one tolerance serves near and
far (Khoshelham & Elberink 2012: std of z = 1.5e-3 z^2, that is 1.5e-3 in w). The picture is cut into small blocks;
each flat block is a candidate plane and a vote: no sampling, so the same frame always gives the same plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_perception.frames.frame import DEPTH_NOISE, FloatImage

Vector = NDArray[np.float64]
Blocks = NDArray[np.float64]


# An upright camera rolls by less than 20 degrees; one that sees a table from the side looks down by less than 70.
ROLL, FACING = 0.34, 0.34


class NoTableError(MbdError):
    """No plane in view that objects could stand on."""


@dataclass(frozen=True)
class Plane:
    """The plane normal . p + offset = 0 in the optical frame.

    Attributes:
        normal: (3,) unit vector towards the camera.
        offset: distance of the camera from the plane [m], positive.
    """

    normal: Vector
    offset: float

    def height(self, depth: FloatImage, camera: Intrinsics) -> FloatImage:
        """Height above the plane [m] of every pixel, (height, width) float32; ``offset`` where there is no depth."""
        x, y = camera.rays()
        ramp = np.float32(self.normal[0]) * x + (np.float32(self.normal[1]) * y + np.float32(self.normal[2]))
        ramp *= depth
        ramp += np.float32(self.offset)
        return ramp

    def tilt(self, up: Vector) -> float:
        """Angle [rad] between the plane's normal and ``up`` (optical frame)."""
        return float(np.arccos(np.clip(self.normal @ up, -1.0, 1.0)))


@dataclass(frozen=True)
class PlaneConfig:
    """How a plane is looked for.

    Attributes:
        noise: std of inverse depth [1/m] of the sensor.
        block: side of a block [px]: small enough to fit between objects, large enough to average noise away.
        max_tilt: largest angle [rad] between table and gravity when the camera's pose is known.
        min_share: smallest share of the blocks with depth that a table fills.
        min_area: a nearer level plane of at least this area [m^2] is the table, and what lies below is floor; the lid
            of a box is smaller.
        max_lid: with another large plane less than this [m] below it, a plane is made of lids; a floor is farther down.
        max_planes: how many planes are distinguished.
    """

    noise: float = DEPTH_NOISE
    block: int = 16
    max_tilt: float = 0.26
    min_share: float = 0.03
    min_area: float = 0.12
    max_lid: float = 0.3
    max_planes: int = 5


@dataclass(frozen=True)
class PlaneCandidate:
    """A plane that was found.

    Attributes:
        plane: it.
        support: how many flat blocks of the picture lie in it.
        area: of all that is seen of it [m^2].
    """

    plane: Plane
    support: int
    area: float


def block_fits(depth: FloatImage, camera: Intrinsics, config: PlaneConfig) -> tuple[Blocks, Blocks]:
    """Planes fitted to blocks of the picture.

    Every second pixel of every fourth row is used: an eighth of the data, the same plane.

    Returns:
        centers (n, 3): ray x', ray y' and inverse depth w at the centre of each block that is nearly full and flat;
        planes (n, 3): A, B, C of its plane w = A x' + B y' + C.
    """
    half = max(config.block // 2, 2)
    high = max(half // 2, 2)
    small = depth[::4, ::2]
    rows, columns = small.shape[0] // high, small.shape[1] // half
    if rows == 0 or columns == 0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    tiles = small[: rows * high, : columns * half].reshape(rows, high, columns, half).transpose(0, 2, 1, 3)
    flat_tiles = tiles.reshape(rows * columns, high * half)
    index = np.flatnonzero((flat_tiles > 0).sum(axis=1) >= 0.5 * high * half)
    cut = flat_tiles[index].astype(np.float64)
    valid = (cut > 0).astype(np.float64)
    w = np.divide(1.0, cut, out=np.zeros_like(cut), where=cut > 0)
    across, down = (np.arange(n) - 0.5 * (n - 1) for n in (half, high))
    terms = np.stack([np.tile(across, high), np.repeat(down, half), np.ones(high * half)])  # du, dv, 1 of each pixel
    products = (terms[:, None] * terms[None]).reshape(9, -1)
    normal_matrix = (valid @ products.T).reshape(-1, 3, 3) + 1e-9 * np.eye(3)
    moments = w @ terms.T
    fit = np.linalg.solve(normal_matrix, moments[..., None])[..., 0]
    # The sum of squares less what the plane explains of it: no need to work out every residual.
    squares = np.einsum("ij,ij->i", w, w) - np.einsum("ij,ij->i", fit, moments)
    variance = squares / normal_matrix[:, 2, 2]
    # Beyond twice the noise the block holds an edge or a curved face.
    flat = variance < (2.0 * config.noise) ** 2
    fit, index = fit[flat], index[flat]
    block_row, block_column = np.divmod(index, columns)
    u = 2.0 * ((block_column + 0.5) * half - 0.5)
    v = 4.0 * ((block_row + 0.5) * high - 0.5)
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    a, b = fit[:, 0] * camera.fx / 2, fit[:, 1] * camera.fy / 4
    centers = np.stack([x, y, fit[:, 2]], axis=1)
    planes = np.stack([a, b, fit[:, 2] - a * x - b * y], axis=1)
    return centers, planes


def find_planes(depth: FloatImage, camera: Intrinsics, config: PlaneConfig, up: Vector | None) -> list[PlaneCandidate]:
    """The planes of a depth image, best supported first.

    Args:
        depth: (height, width) float32 [m], 0 = none; restrict it to the region of interest beforehand.
        camera: its camera.
        config: tolerances.
        up: (3,) unit vector against gravity in the optical frame; only planes within ``max_tilt`` of it count. None
            when not known.
    """
    centers, planes = block_fits(depth, camera, config)
    total = len(centers)
    found: list[PlaneCandidate] = []
    least = max(int(config.min_share * total), 4)
    while len(centers) >= least and len(found) < config.max_planes:
        choice = planes
        if up is not None:
            normals = -planes / np.linalg.norm(planes, axis=1, keepdims=True)
            choice = planes[normals @ up > np.cos(config.max_tilt)]
        if len(choice) == 0:
            break
        choice = choice[:: max(1, len(choice) // 64)]
        rays = np.column_stack([centers[:, :2], np.ones(len(centers))])
        # A block's slope is noisy, and the error grows with the distance it is carried: wide tolerance first.
        error = choice.astype(np.float32) @ rays.T.astype(np.float32)
        error -= centers[:, 2].astype(np.float32)
        votes = np.count_nonzero(np.abs(error, out=error) < 6 * config.noise, axis=1)
        best = choice[int(votes.argmax())]
        inlier = np.abs(rays @ best - centers[:, 2]) < 6 * config.noise
        for tolerance in (5, 4, 3, 3):
            if inlier.sum() < least:
                break
            near = rays[inlier]
            best = np.linalg.solve(near.T @ near + 1e-9 * np.eye(3), near.T @ centers[inlier, 2])
            inlier = np.abs(rays @ best - centers[:, 2]) < tolerance * config.noise
        support = int(inlier.sum())
        if support < least:
            break
        length = float(np.linalg.norm(best))
        plane = Plane(normal=-best / length, offset=1.0 / length)
        found.append(PlaneCandidate(plane, support, _area(depth, camera, plane, config)))
        keep = np.abs(rays @ best - centers[:, 2]) >= 6 * config.noise
        centers, planes = centers[keep], planes[keep]
    return sorted(found, key=lambda c: -c.support)


def _area(depth: FloatImage, camera: Intrinsics, plane: Plane, config: PlaneConfig) -> float:
    """Area [m^2] of what is seen of a plane."""
    stride = 8
    small = depth[::stride, ::stride]
    x, y = camera.rays()
    slant = np.float32(-plane.normal[0]) * x[:, ::stride] - (
        np.float32(plane.normal[1]) * y[::stride] + np.float32(plane.normal[2])
    )
    inverse = np.divide(1, small, out=np.zeros_like(small), where=small > 0)
    flat = (np.abs(inverse - slant / np.float32(plane.offset)) < 4 * config.noise) & (small > 0)
    # A pixel covers (z / f)^2 square to the ray, more on a plane seen at a slant.
    covered = small[flat] ** 2 / np.maximum(slant[flat], np.float32(0.05))
    return float(covered.sum()) * stride**2 / (camera.fx * camera.fy)


def supporting_plane(depth: FloatImage, camera: Intrinsics, config: PlaneConfig, up: Vector | None = None) -> Plane:
    """The plane objects stand on: level, and the nearest of those that are large enough for a table.

    With ``up`` known, level is within ``max_tilt`` of it. Otherwise the camera is taken to be upright, looking ahead or
    down; a wall that faces it is distinguished from a table below it by what else there is: with a table in view from
    the side, what faces the camera is a wall.

    Raises:
        NoTableError: no such plane; the text states what was seen instead.
    """
    found = find_planes(depth, camera, config, up)
    if up is None:
        found = [c for c in found if abs(c.plane.normal[0]) < ROLL and c.plane.normal[1] < ROLL]
        from_the_side = [c for c in found if c.plane.normal[1] < -FACING]
        if from_the_side and max(c.area for c in from_the_side) >= config.min_area:
            found = from_the_side
    if found:
        best = _table_of(found, config)
        if up is None or best.plane.tilt(up) <= config.max_tilt:
            return best.plane
        raise NoTableError(_tilted(best.plane, up))
    others = find_planes(depth, camera, config, None)
    if others and up is not None:
        raise NoTableError(_tilted(others[0].plane, up))
    raise NoTableError(
        "no table in view: no flat surface fills enough of the picture; point the camera at the table, "
        "clear away what covers it, and check the workspace limits"
    )


def _table_of(found: list[PlaneCandidate], config: PlaneConfig) -> PlaneCandidate:
    """The table among level planes, best supported first: the nearest large one, or what lies just below it."""
    large = sorted((c for c in found if c.area >= config.min_area), key=lambda c: c.plane.offset)
    if not large:
        return found[0]
    best = large[0]
    for candidate in large[1:]:
        if candidate.plane.offset - best.plane.offset < config.max_lid:
            best = candidate
    return best


def _tilted(plane: Plane, up: Vector) -> str:
    """What to report when the only plane is not level."""
    return (
        f"no table in view: the largest flat surface is tilted {np.degrees(plane.tilt(up)):.0f} degrees against "
        "level; check the camera's pose (camera_position, camera_orientation) and that it sees the table"
    )
