"""Random rooms with a table, by kind: cases of known truth to try perception on, beyond what anybody posed by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.synthetic.casting import Box, Cylinder, Solid
from mbd_perception.synthetic.paint import Paint, Pattern, Rgb
from mbd_perception.synthetic.render import KINECT, SyntheticView, Table, looking_at, render
from mbd_perception.synthetic.sensors import KINECT_1, KINECT_2, REALSENSE, Sensor

PALETTE: tuple[Rgb, ...] = (
    (200, 40, 40), (40, 160, 60), (40, 60, 190), (220, 200, 50), (225, 225, 220), (60, 60, 65),
    (210, 120, 40), (130, 60, 150), (150, 110, 70), (40, 170, 180),
)  # fmt: skip
KINECT_2_LENS = Intrinsics(fx=365.0, fy=365.0, cx=256.0, cy=212.0, width=512, height=424)
REALSENSE_LENS = Intrinsics(fx=640.0, fy=640.0, cx=640.0, cy=360.0, width=1280, height=720)
LONG_LENS = Intrinsics(fx=900.0, fy=900.0, cx=640.0, cy=360.0, width=1280, height=720)


class Kind(Enum):
    """What is hard about a room."""

    PLAIN = "up to 8 objects, Kinect"
    MANY = "9 to 16 objects"
    COVERED = "objects on half of the table"
    ROOM = "floor, wall, chairs and a person in view"
    TILTED = "camera rolled by up to 12 degrees"
    STACKED = "stacked and touching, turned"
    PRINTED = "printed boxes and striped cups"
    THIN = "things 10 to 15 mm high"
    HOLES = "a fifth to a third of the pixels missing"
    KINECT_1 = "quantised structured light with shadows"
    KINECT_2 = "time of flight, 512x424, mixed pixels"
    REALSENSE = "stereo, 1280x720, blobs of noise"
    LONG_LENS = "900 px, 1280x720"
    DISTORTED = "barrel distortion nobody corrected"
    GREY = "no colour"


@dataclass(frozen=True)
class RandomRoom:
    """A room and what is true in it.

    Attributes:
        view: frame and labels.
        truth: (height, width) int32; 0 = no object, else its number. What hardly shows is no object.
        valid: (height, width) bool; pixels that count.
        solids: what stands on the table; number 1 is the first.
    """

    view: SyntheticView
    truth: NDArray[np.int32]
    valid: NDArray[np.bool_]
    solids: tuple[Solid, ...] = ()


@dataclass(frozen=True)
class FurnishedRoom:
    """A room before anybody has seen it.

    Attributes:
        kind: what is hard about it.
        table: what stands in it stands on this.
        solids: what stands on the table.
        clutter: what else is in the room.
    """

    kind: Kind
    table: Table
    solids: tuple[Solid, ...]
    clutter: tuple[Solid, ...]


def random_room(kind: Kind, rng: np.random.Generator) -> RandomRoom:
    """A room of that kind, seen from somewhere."""
    return photographed(furnished(kind, rng), rng)


def furnished(kind: Kind, rng: np.random.Generator) -> FurnishedRoom:
    """A room of that kind."""
    table = Table(x=(0.35, 1.25), y=(-0.55, 0.55), floor_z=-0.72)
    count = int(rng.integers(9, 17)) if kind in (Kind.MANY, Kind.COVERED) else int(rng.integers(2, 9))
    solids = _standing(kind, count, rng)
    if kind is Kind.STACKED:
        solids = _stacked(solids, rng)
    if kind is Kind.PRINTED:
        solids = [replace(s, paint=_print(rng)) for s in solids]
    clutter: list[Solid] = []
    if kind is Kind.ROOM:
        table = replace(table, wall_x=float(rng.choice([1.255, 1.6, 2.5])))
        clutter = _furniture(rng)
    return FurnishedRoom(kind, table, tuple(solids), tuple(clutter))


def photographed(room: FurnishedRoom, rng: np.random.Generator) -> RandomRoom:
    """A room seen from somewhere, through a camera of its kind."""
    kind = room.kind
    height, back = rng.uniform(0.5, 0.9), rng.uniform(-0.35, 0.0)
    roll = rng.uniform(-0.21, 0.21) if kind is Kind.TILTED else rng.uniform(-0.03, 0.03)
    far = -0.5 if kind is Kind.LONG_LENS else 0.0
    pose = looking_at((back + far, rng.uniform(-0.3, 0.3), height), (0.75, rng.uniform(-0.05, 0.05), 0.0), float(roll))
    lens, sensor = _camera(kind, rng)
    bend = float(rng.uniform(-0.08, 0.08)) if kind is Kind.DISTORTED else 0.0
    view = render(
        room.solids,
        pose,
        rng,
        table=room.table,
        camera=lens,
        clutter=room.clutter,
        sensor=sensor,
        distortion=bend,
    )
    if kind is Kind.GREY:
        grey = RgbdFrame(np.full_like(view.frame.color, 128), view.frame.depth, lens)
        view = replace(view, frame=grey)
    return replace(_with_truth(view), solids=room.solids)


def _camera(kind: Kind, rng: np.random.Generator) -> tuple[Intrinsics, Sensor]:
    """Lens and sensor of a kind of room."""
    if kind is Kind.KINECT_1:
        return KINECT, KINECT_1
    if kind is Kind.KINECT_2:
        return KINECT_2_LENS, KINECT_2
    if kind is Kind.REALSENSE:
        return REALSENSE_LENS, REALSENSE
    if kind is Kind.LONG_LENS:
        return LONG_LENS, Sensor(noise=1e-3)
    missing = float(rng.uniform(0.2, 0.33)) if kind is Kind.HOLES else 0.0
    return KINECT, Sensor(noise=2e-3, missing=missing, bulge=0.004 if kind is Kind.DISTORTED else 0.0)


def _color(rng: np.random.Generator) -> Rgb:
    """A colour of the palette."""
    return PALETTE[int(rng.integers(len(PALETTE)))]


def _print(rng: np.random.Generator) -> Paint:
    """Some print, in two or three colours."""
    pattern = list(Pattern)[int(rng.integers(len(Pattern)))]
    return Paint(pattern, tuple(_color(rng) for _ in range(int(rng.integers(2, 4)))), int(rng.integers(1 << 30)))


def _standing(kind: Kind, count: int, rng: np.random.Generator) -> list[Solid]:
    """Boxes, cylinders, cups and bowls on the table, at least 12 mm apart."""
    solids: list[Solid] = []
    circles: list[tuple[float, float, float]] = []
    for _ in range(60 * count):
        if len(solids) == count:
            break
        shape = rng.choice(["box", "box", "cylinder", "cup", "bowl"])
        low, high = (0.010, 0.015) if kind is Kind.THIN else (0.04, 0.16)
        tall = float(rng.uniform(low, high))
        wide = 1.5 if kind is Kind.COVERED else 1.0
        x, y = float(rng.uniform(0.42, 1.15)), float(rng.uniform(-0.42, 0.42))
        made: Solid
        if shape == "box" or kind is Kind.THIN:
            size = (float(rng.uniform(0.05, 0.13)) * wide, float(rng.uniform(0.05, 0.16)) * wide, tall)
            made = Box((x, y, 0.0), size, _color(rng), float(rng.uniform(-math.pi / 2, math.pi / 2)))
        elif shape == "cylinder":
            made = Cylinder((x, y, 0.0), float(rng.uniform(0.025, 0.045)), tall, _color(rng))
        elif shape == "cup":
            made = Cylinder(
                (x, y, 0.0), float(rng.uniform(0.03, 0.045)), float(rng.uniform(0.07, 0.11)), _color(rng), 0.004
            )
        else:
            made = Cylinder(
                (x, y, 0.0), float(rng.uniform(0.06, 0.1)), float(rng.uniform(0.04, 0.07)), _color(rng), 0.005
            )
        radius = made.reach[0]
        if all(math.hypot(x - a, y - b) > radius + r + 0.012 for a, b, r in circles):
            circles.append((x, y, radius))
            solids.append(made)
    return solids


def _stacked(solids: list[Solid], rng: np.random.Generator) -> list[Solid]:
    """On every second box a smaller thing; beside every other one a box that leans against its side."""
    more: list[Solid] = []
    for number, solid in enumerate(solids):
        if not isinstance(solid, Box):
            continue
        x, y, _ = solid.foot
        if number % 2 == 0:
            small = 0.6 * min(solid.size[:2])
            on_top = (x, y, solid.size[2])
            turned = solid.yaw + float(rng.uniform(0.2, 0.6))
            more.append(
                Box(on_top, (small, small, float(rng.uniform(0.04, 0.1))), _color(rng), turned)
                if rng.random() < 0.7
                else Cylinder(on_top, 0.5 * small, float(rng.uniform(0.05, 0.1)), _color(rng))
            )
    return solids + more


def _furniture(rng: np.random.Generator) -> list[Solid]:
    """A chair behind the table, its back above it, and somebody who stands beside."""
    y = float(rng.uniform(-0.4, 0.4))
    side = float(rng.choice([-1.0, 1.0]))
    return [
        Box((1.45, y, -0.72), (0.05, 0.45, 1.0), (120, 80, 50)),
        Box((1.3 + 0.02, -y, -0.72), (0.04, 0.4, 0.85), (60, 60, 65)),
        Cylinder((0.9, side * 0.78, -0.72), 0.16, 1.6, (70, 80, 140)),
    ]


def _with_truth(view: SyntheticView) -> RandomRoom:
    """Leave out what hardly shows: less than a quarter of itself, 4 cm^2 or 60 pixels."""
    truth = np.where(view.labels > 1, view.labels - 1, 0).astype(np.int32)
    valid = view.frame.depth > 0
    camera = view.frame.camera
    for number, complete in enumerate(view.pixels, start=1):
        mine = truth == number
        area = float((view.frame.depth[mine] ** 2).sum()) / (camera.fx * camera.fy)
        seen = int(mine.sum())
        if seen < max(60, 0.25 * complete * valid.mean()) or area < 4e-4:
            truth[mine], valid[mine] = 0, False
    return RandomRoom(view, truth, valid)
