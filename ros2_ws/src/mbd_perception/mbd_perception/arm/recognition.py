"""Which of the objects found is the robot's own arm, whose joints are known, with the camera's pose or without.

Without a pose the arm's shape is known but not where it is: it is tried at many places. It is there where what was
found lies on its surface, and nothing is seen through the rest of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.camera.pose import CameraPose
from numpy.typing import NDArray

from mbd_perception.arm.description import Matrix, Rods
from mbd_perception.frames.frame import RgbdFrame


@dataclass(frozen=True)
class ArmConfig:
    """When an object is the arm.

    Attributes:
        near: its points lie that near to the surface of the rods, outside or inside [m]: rods are no meshes.
        share: at least this share of them.
        seen_through: at most this share of the arm's points in view may be seen through.
        behind: what is farther than a point of its axis by this is seen through it [m].
        thick: what is nearer than that by more hides it [m].
        there: at least this share of them are seen themselves: neither through nor hidden.
        below, sunk: at most this share of the points may lie lower than that above the table [m].
        long: an arm of unknown place is looked for in objects at least this long [m]: shorter ones look like its parts.
        reach, reach_cut: so long are the pieces found all together [m]; the latter when they leave the picture.
        edge: within that of its border they leave the picture [px].
        tried: of all places that are tried, so many are looked at closely.
        objects: so many objects, the longest, are tried.
        turns: yaw angles that are tried.
        rise: heights of its base above the table that are tried [m].
        sample: points of an object that are looked at.
    """

    near: float = 0.035
    share: float = 0.85
    seen_through: float = 0.2
    behind: float = 0.04
    thick: float = 0.1
    there: float = 0.5
    below: float = -0.03
    sunk: float = 0.05
    long: float = 0.15
    reach: float = 0.45
    reach_cut: float = 0.3
    edge: int = 6
    tried: int = 12
    objects: int = 3
    turns: int = 36
    rise: tuple[float, ...] = (-0.05, 0.0, 0.05)
    sample: int = 150


@dataclass(frozen=True)
class ArmView:
    """How an arm at some place agrees with the picture.

    Attributes:
        through: of its points in view, the share behind which something is seen.
        there: the share that is seen itself.
        sunk: of all its points, the share below the table.
    """

    through: float
    there: float
    sunk: float

    def agrees(self, config: ArmConfig) -> bool:
        """Whether it can be there."""
        return self.through <= config.seen_through and self.there >= config.there and self.sunk <= config.sunk


def arm_labels(
    frame: RgbdFrame,
    labels: NDArray[np.int32],
    arm: Rods,
    pose: CameraPose,
    *,
    known: bool,
    config: ArmConfig | None = None,
) -> frozenset[int]:
    """The objects that are the arm.

    Args:
        frame: what the camera saw.
        labels: (height, width) objects, 0 = none.
        arm: it, as its joints say [base frame].
        pose: of the camera in the frame of the scene.
        known: whether that frame is the base frame; else it is level, on the table.
        config: when an object is the arm.
    """
    config = config or ArmConfig()
    objects = _objects(frame, labels, pose, config)
    if known:
        return frozenset(k for k, o in objects.items() if _share(arm, o.points, config) >= config.share)
    best: tuple[float, frozenset[int]] = 0.0, frozenset()
    for one in sorted(objects.values(), key=lambda o: -o.length)[: config.objects]:
        if one.length < config.long or best[1]:
            break
        for placed in _likeliest(one.points, arm, config):
            settled = _settled(placed, one.points, config)
            # Placed by one piece of it; by all of them it is placed better.
            pieces = [o.points for o in objects.values() if _share(settled, o.points, config) >= 0.5]
            if not pieces:
                continue
            settled = _settled(settled, np.concatenate(pieces), config)
            found = {k: o for k, o in objects.items() if _share(settled, o.points, config) >= config.share}
            view = _view(frame, settled, pose, config)
            if _is_arm(list(found.values()), config) and view.agrees(config) and view.there > best[0]:
                best = view.there, frozenset(found)
    return best[1]


@dataclass(frozen=True)
class Piece:
    """What may be a piece of the arm.

    Attributes:
        points: (n, 3), some of its points [m, frame of the scene].
        length: its largest extent [m].
        cut: whether it leaves the picture.
    """

    points: Matrix
    length: float
    cut: bool


def _objects(frame: RgbdFrame, labels: NDArray[np.int32], pose: CameraPose, config: ArmConfig) -> dict[int, Piece]:
    """The objects of a label picture."""
    columns, rows = frame.camera.rays()
    edge = config.edge
    inner = labels[edge:-edge, edge:-edge]
    found = {}
    for label in range(1, int(labels.max(initial=0)) + 1):
        v, u = np.nonzero(labels == label)
        z = frame.depth[v, u].astype(np.float64)
        points = pose.to_base(np.stack([columns[0, u] * z, rows[v, 0] * z, z], axis=1))
        if len(points) == 0:
            continue
        length = float(np.ptp(points, axis=0).max())
        thinned = points[:: max(1, len(points) // config.sample)]
        found[label] = Piece(thinned, length, int(np.count_nonzero(inner == label)) < len(points))
    return found


def _is_arm(pieces: Sequence[Piece], config: ArmConfig) -> bool:
    """Whether pieces are, all together, too long for things on a table: less so when they leave the picture."""
    if not pieces:
        return False
    length = float(np.ptp(np.concatenate([p.points for p in pieces]), axis=0).max())
    return length >= (config.reach_cut if any(p.cut for p in pieces) else config.reach)


def _share(arm: Rods, points: Matrix, config: ArmConfig) -> float:
    """How many of the points lie on the arm."""
    return float(np.mean(np.abs(arm.distance(points)) < config.near)) if len(points) else 0.0


def _likeliest(points: Matrix, arm: Rods, config: ArmConfig) -> list[Rods]:
    """The arm at the likeliest of many places, no two of them alike: some part of the object on a point of its axis."""
    some = points[:: max(1, len(points) // 40)]
    samples = arm.samples(0.05)
    tried: list[tuple[float, Matrix, Rods]] = []
    for turn in range(config.turns):
        rotation = about_z(2 * math.pi * turn / config.turns)
        turned = samples @ rotation.T
        for anchor in _anchors(points):
            for sample in turned[np.abs(turned[:, 2] - anchor[2]) < 0.1]:
                for rise in config.rise:
                    shift = np.array([*(anchor[:2] - sample[:2]), rise])
                    placed = arm.moved(rotation, shift)
                    tried.append((_cost(placed, some, config), np.array([*shift, turn]), placed))
    tried.sort(key=lambda t: t[0])
    chosen: list[tuple[Matrix, Rods]] = []
    for _, place, placed in tried:
        if all(np.linalg.norm(place[:3] - p[:3]) > 0.06 or abs(place[3] - p[3]) > 1 for p, _ in chosen):
            chosen.append((place, placed))
        if len(chosen) == config.tried:
            break
    return [placed for _, placed in chosen]


def _anchors(points: Matrix) -> list[Matrix]:
    """Middles (3,) of the object, and of its two ends: of something thin and bent the middle may be beside it."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    along = (points - middle) @ axes[0]
    low, high = np.quantile(along, (0.15, 0.85))
    return [middle, points[along <= low].mean(axis=0), points[along >= high].mean(axis=0)]


def _settled(arm: Rods, points: Matrix, config: ArmConfig) -> Rods:
    """The arm turned and shifted, step by step finer, so that it explains the points best."""
    best, cost = arm, _cost(arm, points, config)
    for step in (0.04, 0.02, 0.01, 0.005):
        for _ in range(6):
            middle = np.array([*points[:, :2].mean(axis=0), 0.0])
            before = cost
            for shift, turn in _steps(step):
                rotation = about_z(turn)
                moved = best.moved(rotation, middle - rotation @ middle + shift)
                if (value := _cost(moved, points, config)) < cost:
                    best, cost = moved, value
            if cost >= before:
                break
    return best


def _steps(step: float) -> Iterator[tuple[Matrix, float]]:
    """Shifts [m] along each axis and turns [rad], of one size."""
    for axis in np.eye(3):
        yield step * axis, 0.0
        yield -step * axis, 0.0
    yield np.zeros(3), 3 * step
    yield np.zeros(3), -3 * step


def _cost(arm: Rods, points: Matrix, config: ArmConfig) -> float:
    """How far the points are from the surface, none counting for more than twice ``near``."""
    return float(np.minimum(np.abs(arm.distance(points)), 2 * config.near).mean())


def about_z(angle: float) -> Matrix:
    """(3, 3) turn about the vertical by ``angle`` [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _view(frame: RgbdFrame, arm: Rods, pose: CameraPose, config: ArmConfig) -> ArmView:
    """How the arm agrees with the picture, at points of its axes."""
    camera = frame.camera
    points = arm.samples()
    local = (points - pose.position) @ pose.rotation
    ahead = local[:, 2] > 0.1
    z = np.where(ahead, local[:, 2], 1.0)
    u = np.rint(camera.fx * local[:, 0] / z + camera.cx).astype(int)
    v = np.rint(camera.fy * local[:, 1] / z + camera.cy).astype(int)
    inside: NDArray[np.bool_] = ahead & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    seen = np.where(inside, frame.depth[v.clip(0, camera.height - 1), u.clip(0, camera.width - 1)], 0)
    valid = seen > 0
    if not valid.any():
        return ArmView(1.0, 0.0, 1.0)
    through = seen > local[:, 2] + config.behind
    there = ~through & (seen > local[:, 2] - config.thick)
    below = float(np.mean(points[:, 2] < config.below))
    return ArmView(float(np.mean(through[valid])), float(np.mean(there[inside])), below)
