"""The planes of a depth image: small flat blocks are candidates and votes, so the same frame gives the same planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics

from mbd_perception.frames.frame import FloatImage
from mbd_perception.quantile import interpolated_quantile, median
from mbd_perception.segmentation.table.plane import Blocks, Plane, PlaneCandidate, PlaneConfig, Vector

# Every eighth pixel of every eighth row is enough for an area.
STRIDE = 8


def block_fits(depth: FloatImage, camera: Intrinsics, config: PlaneConfig) -> tuple[Blocks, Blocks, float]:
    """Planes fitted to blocks of the picture.

    Every second pixel of every fourth row is used: an eighth of the data, the same plane.

    Returns:
        centers (n, 3): ray x', ray y' and inverse depth w at the centre of each block that is nearly full and flat;
        planes (n, 3): A, B, C of its plane w = A x' + B y' + C;
        noise: std of w [1/m] to be reckoned with in this picture, ``config.noise`` or more.
    """
    half = max(config.block // 2, 2)
    high = max(half // 2, 2)
    small = depth[::4, ::2]
    rows, columns = small.shape[0] // high, small.shape[1] // half
    if rows == 0 or columns == 0:
        return np.zeros((0, 3)), np.zeros((0, 3)), config.noise
    tiles = small[: rows * high, : columns * half].reshape(rows, high, columns, half).transpose(0, 2, 1, 3)
    flat_tiles = tiles.reshape(rows * columns, high * half)
    index = np.flatnonzero((flat_tiles > 0).sum(axis=1) >= 0.5 * high * half)
    cut = flat_tiles[index].astype(np.float64)
    valid = (cut > 0).astype(np.float64)
    w = np.divide(1.0, cut, out=np.zeros_like(cut), where=cut > 0)
    across, down = (np.arange(n) - 0.5 * (n - 1) for n in (half, high))
    terms = np.stack([np.tile(across, high), np.repeat(down, half), np.ones(high * half)])  # du, dv, 1 of each pixel
    products = (terms[:, None] * terms[None]).reshape(9, -1)
    moments = w @ terms.T
    pixels = valid.sum(axis=1)
    # Most blocks are full, and one matrix serves them all.
    full = (products.sum(axis=1)).reshape(3, 3) + 1e-9 * np.eye(3)
    fit = moments @ np.linalg.inv(full).T
    partly = np.flatnonzero(pixels < high * half)
    if len(partly):
        matrices = (valid[partly] @ products.T).reshape(-1, 3, 3) + 1e-9 * np.eye(3)
        fit[partly] = np.linalg.solve(matrices, moments[partly, :, None])[..., 0]
    # The sum of squares less what the plane explains of it: no need to work out every residual.
    squares = np.einsum("ij,ij->i", w, w) - np.einsum("ij,ij->i", fit, moments)
    variance = squares / pixels
    noise = _frame_noise(w.reshape(-1, high, half), variance, config)
    # Beyond twice the noise the block holds an edge or a curved face.
    flat = variance < (2.0 * noise) ** 2
    fit, index = fit[flat], index[flat]
    block_row, block_column = np.divmod(index, columns)
    u = 2.0 * ((block_column + 0.5) * half - 0.5)
    v = 4.0 * ((block_row + 0.5) * high - 0.5)
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    a, b = fit[:, 0] * camera.fx / 2, fit[:, 1] * camera.fy / 4
    centers = np.stack([x, y, fit[:, 2]], axis=1)
    planes = np.stack([a, b, fit[:, 2] - a * x - b * y], axis=1)
    return centers, planes, noise


def _frame_noise(w: Blocks, variance: Blocks, config: PlaneConfig) -> float:
    """Std of inverse depth to be reckoned with [1/m]: ``config.noise``, or what the frame shows.

    Args:
        w: (n, rows, columns) inverse depth of the blocks, 0 = none.
        variance: (n,) mean squared error of their planes.
        config: the expected noise and how far it may be exceeded.
    """
    if len(variance) == 0:
        return config.noise
    pixel = min(_pixel_noise(w) / config.uneven, config.noisiest * config.noise)
    # Bumps that are wider than a pixel show in the planes only; so does shape, and they are believed less.
    bumps = float(np.sqrt(max(interpolated_quantile(variance, 0.3), 0.0))) / config.uneven
    return max(config.noise, pixel, min(bumps, config.bumpiest * config.noise))


def _pixel_noise(w: Blocks) -> float:
    """Std of inverse depth from pixel to pixel [1/m], from its second differences along the rows of blocks.

    Shape hardly shows in them, other than in the errors of a fitted plane.

    Args:
        w: (n, rows, columns) inverse depth, 0 = none.
    """
    some = w[::3]
    if some.shape[2] < 3:
        return 0.0
    left, middle, right = some[:, :, :-2], some[:, :, 1:-1], some[:, :, 2:]
    second = np.abs(left - 2 * middle + right)[(left > 0) & (middle > 0) & (right > 0)]
    return median(second) / (0.6745 * np.sqrt(6.0)) if second.size else 0.0


def find_planes(depth: FloatImage, camera: Intrinsics, config: PlaneConfig, up: Vector | None) -> list[PlaneCandidate]:
    """The planes of a depth image, best supported first.

    Args:
        depth: (height, width) float32 [m], 0 = none; restrict it to the region of interest beforehand.
        camera: its camera.
        config: tolerances.
        up: (3,) unit vector against gravity in the optical frame; only planes within ``max_tilt`` of it count. None
            when not known.
    """
    centers, planes, noise = block_fits(depth, camera, config)
    config = replace(config, noise=noise)
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
        found.append(PlaneCandidate(plane, support, *seen_area(depth, camera, [plane], config), noise))
        keep = np.abs(rays @ best - centers[:, 2]) >= 6 * config.noise
        centers, planes = centers[keep], planes[keep]
    return sorted(found, key=lambda c: -c.support)


def inverse_error(depth: FloatImage, camera: Intrinsics, plane: Plane) -> FloatImage:
    """Inverse depth less that of the plane [1/m] on every ``STRIDE``-th pixel and row; positive above the plane.

    Where there is no depth it is that of a point infinitely far away.
    """
    small = depth[::STRIDE, ::STRIDE]
    inverse = np.divide(1, small, out=np.zeros_like(small), where=small > 0)
    error: FloatImage = inverse - _slant(camera, plane) / np.float32(plane.offset)
    return error


def _slant(camera: Intrinsics, plane: Plane) -> FloatImage:
    """Minus normal . ray of the coarse pixels."""
    x, y = camera.rays()
    slant: FloatImage = np.float32(-plane.normal[0]) * x[:, ::STRIDE] - (
        np.float32(plane.normal[1]) * y[::STRIDE] + np.float32(plane.normal[2])
    )
    return slant


def seen_area(
    depth: FloatImage, camera: Intrinsics, planes: Sequence[Plane], config: PlaneConfig
) -> tuple[float, float]:
    """Area [m^2] of what is seen of planes that are nearly the same, and of its largest piece."""
    small = depth[::STRIDE, ::STRIDE]
    flat = np.zeros(small.shape, dtype=bool)
    for plane in planes:
        flat |= (np.abs(inverse_error(depth, camera, plane)) < 4 * config.noise) & (small > 0)
    # A pixel covers (z / f)^2 square to the ray, more on a plane seen at a slant.
    covered = np.where(flat, small**2 / np.maximum(_slant(camera, planes[0]), np.float32(0.05)), 0)
    count, patches = cv2.connectedComponents(flat.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    pieces = np.bincount(patches.ravel(), weights=covered.ravel(), minlength=max(count, 2))[1:]
    scale = STRIDE**2 / (camera.fx * camera.fy)
    return float(pieces.sum()) * scale, float(pieces.max()) * scale
