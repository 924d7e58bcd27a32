"""Where the table is by the depth camera, against where the robot believes it: at z = its height, level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.transforms import Transforms

NEAR = 0.08  # [m] above or below the table where its points are looked for
FLAT = 0.004  # [m] from the plane within which a point is the table's
TRIES, STEEPEST = 300, 0.15  # of planes by three points; slope of one
FEWEST = 300  # points
SEED = 3


@dataclass(frozen=True)
class TableArea:
    """The part of the table that is worked on [m, base frame].

    Attributes:
        x: lowest and highest.
        y: lowest and highest.
        height: of the table's top, z.
    """

    x: tuple[float, float] = (0.25, 1.3)
    y: tuple[float, float] = (-0.7, 0.7)
    height: float = 0.0

    @property
    def outline(self) -> NDArray[np.float64]:
        """(4, 3) its corners, around."""
        (x0, x1), (y0, y1), z = self.x, self.y, self.height
        return np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])


@dataclass(frozen=True)
class TableSeen:
    """The table as depth shows it, with a camera pose taken for true.

    Attributes:
        plane: (3,) a, b, c of z = a + b x + c y [m, base frame].
        centre: (2,) x, y in the middle of the table's points [m].
        span: (2, 2) lowest and highest x, and y, of those points [m].
        share: of the points near the table that lie on the plane.
    """

    plane: NDArray[np.float64]
    centre: NDArray[np.float64]
    span: NDArray[np.float64]
    share: float

    def height(self, x: float, y: float) -> float:
        """[m] of the table there."""
        return float(self.plane @ (1.0, x, y))

    @property
    def tilt(self) -> float:
        """[deg] of the table against level."""
        return float(np.degrees(np.arctan(np.hypot(*self.plane[1:]))))

    def errors(self, expected: float) -> tuple[float, float]:
        """[m] that the table's middle is too high, and the largest error at the corners of what is seen of it."""
        corners = [self.height(x, y) - expected for x in self.span[0] for y in self.span[1]]
        return self.height(*self.centre) - expected, float(max(corners, key=abs))


def table_seen(
    depth: NDArray[np.float32], lens: CalibratedLens, camera2base: Transforms, area: TableArea
) -> TableSeen:  # fmt: skip
    """Fit the plane that most points near the table lie on.

    Args:
        depth: (H, W) [m], registered to colour; 0 or NaN where nothing returned.
        lens: of the picture.
        camera2base: (4, 4).
        area: where the table is looked for.

    Raises:
        CalibrationError: hardly any point is near where the table should be.
    """
    rows, columns = np.nonzero(np.isfinite(depth) & (depth > 0.05))
    z = depth[rows, columns].astype(np.float64)
    p = lens.pinhole
    points = np.stack((z * (columns - p.cx) / p.fx, z * (rows - p.cy) / p.fy, z), axis=1)
    points = points @ camera2base[:3, :3].T + camera2base[:3, 3]
    inside = (
        (np.abs(points[:, 2] - area.height) < NEAR)
        & (points[:, 0] > area.x[0]) & (points[:, 0] < area.x[1])
        & (points[:, 1] > area.y[0]) & (points[:, 1] < area.y[1])
    )  # fmt: skip
    points = points[inside]
    if len(points) < FEWEST:
        raise CalibrationError(
            f"{len(points)} points of the depth image are within {NEAR * 100:.0f} cm of where the table should be (z = "
            f"{area.height:g} m in the base frame); the pose is off by more than that, or the table is elsewhere: "
            "--area, --table-height"
        )
    rng = np.random.default_rng(SEED)
    some = points[rng.choice(len(points), min(4000, len(points)), replace=False)]
    best = -1
    plane: NDArray[np.float64] = np.zeros(3)
    for _ in range(TRIES):
        three = some[rng.choice(len(some), 3, replace=False)]
        try:
            tried = np.asarray(np.linalg.solve(np.column_stack((np.ones(3), three[:, :2])), three[:, 2]), np.float64)
        except np.linalg.LinAlgError:
            continue
        on = int((np.abs(_above(some, tried)) < FLAT).sum())
        if on > best and np.hypot(*tried[1:]) < STEEPEST:
            best, plane = on, tried
    for _ in range(3):
        on_plane = points[np.abs(_above(points, plane)) < FLAT]
        system = np.column_stack((np.ones(len(on_plane)), on_plane[:, :2]))
        plane = np.asarray(np.linalg.lstsq(system, on_plane[:, 2], rcond=None)[0], np.float64)
    span = np.quantile(on_plane[:, :2], (0.02, 0.98), axis=0).T
    return TableSeen(plane, np.median(on_plane[:, :2], axis=0), span, len(on_plane) / len(points))


def _above(points: NDArray[np.float64], plane: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(points[:, 2] - plane[0] - points[:, :2] @ plane[1:])
