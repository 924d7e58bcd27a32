"""Where objects appear in the camera's picture, and where on the table a pixel lies."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from mbd_model.camera.view import CameraView
from mbd_model.geometry.boxes import box_corners
from mbd_model.objects import SceneObject
from scipy.spatial import ConvexHull, QhullError

Pixel = tuple[float, float]


@dataclass(frozen=True)
class ObjectOutline:
    """An object in the picture.

    Attributes:
        thing: the object.
        corners: of the convex outline of its box, in order around it [px, u right, v down].
        middle: where its centroid appears [px].
    """

    thing: SceneObject
    corners: tuple[Pixel, ...]
    middle: Pixel

    @property
    def top(self) -> Pixel:
        """Middle of its upper edge [px]."""
        left, right = min(u for u, _ in self.corners), max(u for u, _ in self.corners)
        return ((left + right) / 2, min(v for _, v in self.corners))

    @property
    def bottom(self) -> Pixel:
        """Middle of its lower edge [px]."""
        return (self.top[0], max(v for _, v in self.corners))


def outlines(view: CameraView, things: Iterable[SceneObject]) -> tuple[ObjectOutline, ...]:
    """Outlines of the objects that lie before the camera, the farthest first: nearer ones are drawn over them."""
    found = []
    for thing in things:
        seen = view.project(np.vstack([box_corners(thing), thing.centroid]))
        if not np.isfinite(seen).all():
            continue
        try:
            around = seen[ConvexHull(seen[:8]).vertices]
        except QhullError:
            continue  # seen exactly edge-on: a line has no outline
        distance = float(np.linalg.norm(np.asarray(thing.centroid) - view.pose.position))
        corners = tuple((float(u), float(v)) for u, v in around)
        found.append((distance, ObjectOutline(thing, corners, (float(seen[8, 0]), float(seen[8, 1])))))
    return tuple(outline for _, outline in sorted(found, key=lambda pair: -pair[0]))


def point_on_table(
    view: CameraView, plane: tuple[float, float, float, float], pixel: Pixel
) -> tuple[float, float, float] | None:
    """The point of the table's plane (a, b, c, d) [m, base frame] that a pixel shows; None where it shows none.

    Inverse of the projection: projecting the point gives the pixel.
    """
    fx, fy, cx, cy = view.intrinsics
    width, height = view.size
    if not (0 <= pixel[0] <= width and 0 <= pixel[1] <= height):
        return None
    ray = view.pose.rotation @ np.array([(pixel[0] - cx) / fx, (pixel[1] - cy) / fy, 1.0])
    normal, offset = np.asarray(plane[:3]), plane[3]
    slope = float(normal @ ray)
    if abs(slope) < 1e-9:
        return None
    along = -float(normal @ view.pose.position + offset) / slope
    if along <= 0:
        return None
    x, y, z = view.pose.position + along * ray
    return (float(x), float(y), float(z))
