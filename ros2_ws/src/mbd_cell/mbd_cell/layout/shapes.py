"""Objects as MuJoCo bodies: what is seen (smooth hollow meshes) apart from what collides (boxes).

Box against box is the one pair of MuJoCo with a complete contact patch, so a cup on a cup stands as a real one does.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

from mbd_cell.layout.scenes import ObjectSpec, Shape

SATURATION = 0.8
VALUE = 0.8
GREY = (0.55, 0.55, 0.55, 1.0)
WALL = 0.005  # thickness of a cup's or bowl's wall [m]; the camera resolves no thinner rim
FLOOR = 0.003  # of its floor [m]
CUP_TAPER = 0.95  # outer diameter of the floor as a share of the rim's
BOWL_TAPER = 0.62
TRAY_WALL = 0.006
# A raised floor: what stands on it is not lost behind the walls, neither to the hand nor to the camera.
TRAY_FLOOR = 0.036
VISIBLE, HIDDEN = 1, 3  # geom groups; the renderer draws 0, 1 and 2
SEGMENTS = 32  # of a round visual mesh
WALL_BOXES = 16  # of a round collision wall: the corners over which a lying cup rolls are 0.7 mm high
LIP_BALLS = 8  # of a rim: one contact each, where boxes would make forty
RECESS = 0.0005  # by which walls stay off what the floor stands on [m]


def rgba(hue: float | None) -> tuple[float, float, float, float]:
    """Colour of that hue [deg] at the catalogue's saturation and value; grey for None."""
    if hue is None:
        return GREY
    return (*colorsys.hsv_to_rgb(hue / 360.0, SATURATION, VALUE), 1.0)


def taper(shape: Shape) -> float:
    """Outer diameter of the floor as a share of the rim's."""
    return BOWL_TAPER if shape is Shape.BOWL else CUP_TAPER


def add_object(
    spec: mujoco.MjSpec,
    thing: ObjectSpec,
    position: tuple[float, float, float],
    yaw: float,
    friction: tuple[float, float, float],
) -> None:
    """Add a free body named as the object, its origin in the centre of its bounding box.

    Args:
        spec: the model under construction, changed in place.
        thing: what to add.
        position: centre of the box [m, world = robot base frame].
        yaw: about z [rad].
        friction: sliding [-], torsional [m], rolling [m].
    """
    body = spec.worldbody.add_body(name=thing.name, pos=position, quat=(math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)))
    # Air, so to speak: what rolls is slowed by its friction, and nothing rocks for ever.
    joint = body.add_freejoint(name=thing.name)
    joint.damping = np.array([2e-5, 0.0, 0.0])
    _BUILDERS[thing.shape](spec, body, thing)
    for geom in body.geoms:
        geom.friction = np.array(friction)


def _solid(body: mujoco.MjsBody, thing: ObjectSpec, boxes: list[tuple[NDArray[np.float64], ...]]) -> None:
    """Add hidden collision boxes (centre, half size, quaternion wxyz), the mass shared by volume."""
    volumes = np.array([float(np.prod(half)) for _, half, _ in boxes])
    for (centre, half, quaternion), volume in zip(boxes, volumes / volumes.sum(), strict=True):
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, pos=centre, size=half, quat=quaternion, mass=thing.mass * volume,
            group=HIDDEN, condim=3, contype=1, conaffinity=1,
        )  # fmt: skip


def _visual_mesh(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    thing: ObjectSpec,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int32],
) -> None:
    mesh = spec.add_mesh(name=thing.name, uservert=vertices.ravel(), userface=faces.ravel())
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH, meshname=thing.name, rgba=rgba(thing.hue), mass=0.0, group=VISIBLE,
        contype=0, conaffinity=0,
    )  # fmt: skip


def _add_round(spec: mujoco.MjSpec, body: mujoco.MjsBody, thing: ObjectSpec) -> None:
    """A cup or bowl: a tapered hollow, floor at the bottom (at the top when upside down)."""
    flip = -1.0 if thing.upside_down else 1.0
    rim, half_height = thing.size[0] / 2, thing.size[2] / 2
    foot = rim * taper(thing.shape)
    # Profile from the outer floor's centre up the outside, over the rim and down the inside: (radius, height).
    profile = [
        (0.0, -half_height), (foot, -half_height), (rim, half_height), (rim - WALL, half_height),
        (foot - WALL, -half_height + FLOOR), (0.0, -half_height + FLOOR),
    ]  # fmt: skip
    vertices, faces = _revolve(profile, flip)
    _visual_mesh(spec, body, thing, vertices, faces)
    boxes = _floor_boxes(foot, -half_height, flip)
    lean = math.atan2(rim - foot, thing.size[2])
    # From just above what the floor stands on to just below the rim, which is the lip's.
    length = (thing.size[2] - 2 * RECESS - WALL * math.sin(lean)) / math.cos(lean)
    width = rim * math.tan(math.pi / WALL_BOXES)
    for k in range(WALL_BOXES):
        angle = 2 * math.pi * k / WALL_BOXES
        radius = (rim + foot) / 2 - WALL / 2
        centre = np.array([radius * math.cos(angle), radius * math.sin(angle), 0.0])
        # About z to the side, then about y outwards (inwards when upside down: the wide end is below).
        turn = _product(_about("z", angle), _about("y", flip * lean))
        boxes.append((centre, np.array([WALL / 2, width, length / 2]), turn))
    _solid(body, thing, boxes)
    for k in range(LIP_BALLS):
        angle = 2 * math.pi * (k + 0.5) / LIP_BALLS
        radius, height = rim - WALL / 2, flip * (half_height - WALL / 2)
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=(radius * math.cos(angle), radius * math.sin(angle), height),
            size=(WALL / 2, 0.0, 0.0), mass=0.0, group=HIDDEN, condim=3, contype=1, conaffinity=1,
        )  # fmt: skip


def _floor_boxes(foot: float, bottom: float, flip: float) -> list[tuple[NDArray[np.float64], ...]]:
    """Two squares turned by 45 degrees: an octagonal star within the floor."""
    half = np.array([foot / math.sqrt(2), foot / math.sqrt(2), FLOOR / 2])
    centre = np.array([0.0, 0.0, flip * (bottom + FLOOR / 2)])
    return [(centre, half, _about("z", 0.0)), (centre, half, _about("z", math.pi / 4))]


def _revolve(profile: list[tuple[float, float]], flip: float) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Surface of revolution of a (radius, height) profile about z, outward normals; flip = -1 turns it upside down."""
    angles = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    rings = [np.column_stack((r * np.cos(angles), r * np.sin(angles), np.full(SEGMENTS, h))) for r, h in profile]
    vertices = np.concatenate(rings)
    if flip < 0:
        vertices = vertices * np.array([1.0, -1.0, -1.0])
    faces = []
    for ring in range(len(profile) - 1):
        for k in range(SEGMENTS):
            a, b = ring * SEGMENTS + k, ring * SEGMENTS + (k + 1) % SEGMENTS
            c, d = a + SEGMENTS, b + SEGMENTS
            if profile[ring][0] > 0:
                faces.append((a, b, d))
            if profile[ring + 1][0] > 0:
                faces.append((a, d, c))
    return vertices, np.array(faces, dtype=np.int32)


def _add_tray(spec: mujoco.MjSpec, body: mujoco.MjsBody, thing: ObjectSpec) -> None:
    """An open box; its walls are seen as they collide."""
    x, y, z = (v / 2 for v in thing.size)
    t, floor = TRAY_WALL, TRAY_FLOOR / 2
    parts = [
        ((0.0, 0.0, -z + floor), (x, y, floor)),
        ((x - t / 2, 0.0, floor), (t / 2, y, z - floor)),
        ((-x + t / 2, 0.0, floor), (t / 2, y, z - floor)),
        ((0.0, y - t / 2, floor), (x - t, t / 2, z - floor)),
        ((0.0, -y + t / 2, floor), (x - t, t / 2, z - floor)),
    ]
    for centre, half in parts:
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, pos=centre, size=half, rgba=rgba(thing.hue), mass=thing.mass / len(parts),
            group=VISIBLE, condim=3, contype=1, conaffinity=1,
        )  # fmt: skip


def _add_box(spec: mujoco.MjSpec, body: mujoco.MjsBody, thing: ObjectSpec) -> None:
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=[v / 2 for v in thing.size], rgba=rgba(thing.hue), mass=thing.mass,
        group=VISIBLE, condim=3, contype=1, conaffinity=1,
    )  # fmt: skip


def _add_ellipsoid(spec: mujoco.MjSpec, body: mujoco.MjsBody, thing: ObjectSpec) -> None:
    """A fruit or ball: it touches in a point and rolls, with the rolling resistance of its friction."""
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=[v / 2 for v in thing.size], rgba=rgba(thing.hue), mass=thing.mass,
        group=VISIBLE, condim=6, contype=1, conaffinity=1,
    )  # fmt: skip


def _add_utensil(spec: mujoco.MjSpec, body: mujoco.MjsBody, thing: ObjectSpec) -> None:
    """A handle along x with a wider head at its +x end."""
    x, y, z = (v / 2 for v in thing.size)
    colour = rgba(thing.hue)
    head = 0.3 * x
    for centre, half in (((-head, 0.0, 0.0), (x - head, 0.6 * y, z)), ((x - head, 0.0, 0.0), (head, y, z))):
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, pos=centre, size=half, rgba=colour, mass=thing.mass / 2,
            group=VISIBLE, condim=3, contype=1, conaffinity=1,
        )  # fmt: skip


def _about(axis: str, angle: float) -> NDArray[np.float64]:
    """Quaternion (w, x, y, z) of a turn about one axis."""
    s = math.sin(angle / 2)
    return np.array([math.cos(angle / 2), s * (axis == "x"), s * (axis == "y"), s * (axis == "z")])


def _product(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Quaternion product a b (w, x, y, z)."""
    result = np.zeros(4)
    mujoco.mju_mulQuat(result, a, b)
    return result


_BUILDERS: dict[Shape, Callable[[mujoco.MjSpec, mujoco.MjsBody, ObjectSpec], None]] = {
    Shape.CUP: _add_round,
    Shape.BOWL: _add_round,
    Shape.TRAY: _add_tray,
    Shape.BOX: _add_box,
    Shape.ELLIPSOID: _add_ellipsoid,
    Shape.UTENSIL: _add_utensil,
}
