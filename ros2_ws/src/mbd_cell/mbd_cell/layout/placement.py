"""Random places on the table for a set of objects, none near another and all within the arm's reach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.task import StepKind

from mbd_cell.layout.scenes import Arrangement, ObjectSpec, Shape, TaskScenes

# Object centres lie here (x_min, x_max, y_min, y_max) [m, robot base frame], and within MAX_REACH of it: measured,
# the hand pointing down reaches every such place at tool heights of 0.01 to 0.3 m.
REGION = (0.27, 0.60, -0.39, 0.39)
MAX_REACH = 0.64
# Between outlines: an open finger reaches 8 cm from the tool's axis, and segmenting the depth image wants 5 cm.
MIN_GAP = 0.065
# Around what the demonstration will set down there is less to pass.
RESERVED_GAP = 0.03
# Where rows stand [m]: the far row within reach at the height of a tower, the largest bowls apart.
ROWS = (0.29, 0.51)
COLUMNS = (-0.24, 0.0, 0.24)
UNTIDINESS = 0.012  # [m]
# Where spares lie: on the floor, out of the camera's sight, this far apart.
BESIDE_TABLE, BESIDE_GAP = (2.0, 2.0), 0.4
LAYOUT_STREAM = 1  # of chance, apart from those of the teacher and the camera


@dataclass(frozen=True)
class Placement:
    """Where an object stands: (x, y) of its centre [m] and yaw [rad], robot base frame."""

    name: str
    x: float
    y: float
    yaw: float


def layout(scenes: TaskScenes, role: Role, seed: int) -> tuple[Placement, ...]:
    """Where each object of that set stands, in the set's order: a function of its arguments only.

    Raises:
        MbdError: the set does not fit on the table.
    """
    objects = scenes.source if role is Role.SOURCE else scenes.target
    rng = np.random.default_rng([seed, LAYOUT_STREAM, role is Role.TARGET])
    if scenes.arrangement is Arrangement.ROWS:
        placed = place_in_rows(objects, rng)
    else:
        placed = place_randomly(objects, rng, reserved_spots(scenes) if role is Role.SOURCE else ())
    if role is Role.SOURCE:
        return placed
    x, y = BESIDE_TABLE
    return placed + tuple(Placement(o.name, x, y + k * BESIDE_GAP, 0.0) for k, o in enumerate(scenes.spares))


def reserved_spots(scenes: TaskScenes) -> tuple[tuple[float, float, float], ...]:
    """(x, y, radius) [m] of what the demonstration sets down on the table itself."""
    radius = {o.name: o.footprint_radius for o in scenes.source}
    return tuple((*s.position, radius[s.picked]) for s in scenes.steps if s.kind is StepKind.PLACE and s.onto is None)


def place_in_rows(objects: Sequence[ObjectSpec], rng: np.random.Generator) -> tuple[Placement, ...]:
    """Two rows of three places, filled in random order; with five objects the near row's middle stays free.

    Raises:
        MbdError: more objects than places.
    """
    cells = [(x, y) for x in ROWS for y in COLUMNS]
    if len(objects) > len(cells):
        raise MbdError(f"rows hold {len(cells)} objects, this set has {len(objects)}; use 'arrangement: scattered'")
    if len(objects) < len(cells):
        cells.remove((ROWS[0], COLUMNS[1]))
    order = rng.permutation(len(cells))[: len(objects)]
    placements = []
    for spec, cell in zip(objects, order, strict=True):
        dx, dy = rng.uniform(-UNTIDINESS, UNTIDINESS, 2)
        x, y = cells[int(cell)]
        placements.append(Placement(spec.name, x + float(dx), y + float(dy), _random_yaw(spec, rng)))
    return tuple(placements)


def place_randomly(
    objects: Sequence[ObjectSpec],
    rng: np.random.Generator,
    reserved: Sequence[tuple[float, float, float]] = (),
    attempts: int = 4000,
) -> tuple[Placement, ...]:
    """Places with at least MIN_GAP between the circles about any two objects' outlines.

    Args:
        objects: what to place.
        rng: the only source of chance.
        reserved: (x, y, radius) of spots [m] that stay free.
        attempts: complete layouts tried before giving up.

    Raises:
        MbdError: no layout was found; the table is too full.
    """
    # The largest first: a small one still fits into what they leave.
    order = sorted(range(len(objects)), key=lambda i: (-objects[i].footprint_radius, i))
    for _ in range(attempts):
        placed: dict[int, Placement] = {}
        for i in order:
            candidate = _try_one(objects[i], objects, placed, reserved, rng)
            if candidate is None:
                break
            placed[i] = candidate
        else:
            return tuple(placed[i] for i in range(len(objects)))
    raise MbdError(
        f"no free layout for {[o.name for o in objects]} in {attempts} tries: at least {MIN_GAP} m between any two in "
        f"x, y of {REGION} m does not fit; use fewer or smaller objects"
    )


def _try_one(
    spec: ObjectSpec,
    objects: Sequence[ObjectSpec],
    placed: dict[int, Placement],
    reserved: Sequence[tuple[float, float, float]],
    rng: np.random.Generator,
) -> Placement | None:
    x_min, x_max, y_min, y_max = spec.region or REGION
    for _ in range(30):
        x = float(rng.uniform(x_min, x_max))
        y = float(rng.uniform(y_min, y_max))
        yaw = _random_yaw(spec, rng)
        if math.hypot(x, y) > MAX_REACH:
            continue
        radius = spec.footprint_radius
        near = any(
            math.hypot(x - p.x, y - p.y) < radius + objects[i].footprint_radius + MIN_GAP for i, p in placed.items()
        ) or any(math.hypot(x - rx, y - ry) < radius + r + RESERVED_GAP for rx, ry, r in reserved)
        if not near:
            return Placement(spec.name, x, y, yaw)
    return None


def _random_yaw(spec: ObjectSpec, rng: np.random.Generator) -> float:
    # A large box turned at random would stick out of reach.
    limit = math.radians(15.0) if spec.shape is Shape.TRAY else math.pi / 2
    return float(rng.uniform(-limit, limit))
