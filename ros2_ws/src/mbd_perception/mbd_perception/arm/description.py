"""Where the links of an arm are, by its description and its joints: as rods, thick lines its surface is near to."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_perception.arm.joint import Joint
from mbd_perception.arm.mjcf import MjcfReader

Matrix = NDArray[np.float64]
# Half the thickness of a link whose shape is a mesh [m]: arms of this kind are 7 to 12 cm thick.
USUAL_RADIUS = 0.05
# Joints that turn or move.
TURNING, SLIDING = ("revolute", "continuous"), "prismatic"


class DescriptionError(MbdError):
    """A robot description that states no arm."""


@dataclass(frozen=True)
class Rods:
    """The arm at one moment, as capsules.

    Attributes:
        ends: (k, 2, 3) ends of their axes [m, base frame].
        radii: (k,) [m].
    """

    ends: Matrix
    radii: Matrix

    def moved(self, rotation: Matrix, shift: Matrix) -> Rods:
        """The same in another frame: turned by (3, 3), then shifted by (3,) [m]."""
        return Rods(self.ends @ rotation.T + shift, self.radii)

    def distance(self, points: Matrix) -> Matrix:
        """(n,) distance [m] of (n, 3) points from the nearest rod's surface; negative inside."""
        start, way = self.ends[:, 0], self.ends[:, 1] - self.ends[:, 0]
        square = np.maximum((way * way).sum(axis=1), 1e-12)
        offset = points[:, None] - start[None]
        share = np.clip((offset * way[None]).sum(axis=2) / square, 0.0, 1.0)
        away = np.linalg.norm(offset - share[..., None] * way[None], axis=2)
        return np.asarray((away - self.radii[None]).min(axis=1))

    def samples(self, step: float = 0.03) -> Matrix:
        """(n, 3) points of the axes, about every ``step`` [m]."""
        parts = []
        for start, end in self.ends:
            count = max(int(np.linalg.norm(end - start) / step), 1) + 1
            parts.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
        return np.concatenate(parts)


@dataclass(frozen=True)
class ArmDescription:
    """The chain of joints of a robot.

    Attributes:
        root: link that has no parent.
        joints: all of them.
        shapes: by link, (from, to, radius) of its simple shapes [m, frame of the link].
    """

    root: str
    joints: tuple[Joint, ...]
    shapes: Mapping[str, tuple[tuple[Matrix, Matrix, float], ...]] = field(default_factory=dict)

    @property
    def needed(self) -> frozenset[str]:
        """Names of the joints without which nobody knows where the arm is: those that move other joints, no fingers."""
        moving = {j.child: j for j in self.joints if j.name in self.movable}
        carrying: set[str] = set()
        above = {j.child: j for j in self.joints}
        for joint in moving.values():
            link = joint.parent
            while link in above and above[link].name not in carrying:
                carrying.add(above[link].name)
                link = above[link].parent
        return frozenset(carrying & self.movable) or self.movable

    @property
    def movable(self) -> frozenset[str]:
        """Names of the joints whose positions are needed."""
        return frozenset(j.name for j in self.joints if j.kind in TURNING or j.kind == SLIDING)

    def rods(self, positions: Mapping[str, float], base: str) -> Rods:
        """Where the links are.

        Args:
            positions: of the joints by name [rad or m]; those that are missing are 0 (fingers).
            base: link whose frame is the base frame; the root when there is no such link.
        """
        poses: dict[str, Matrix] = {self.root: np.eye(4)}
        waiting = list(self.joints)
        while waiting:
            ready = [j for j in waiting if j.parent in poses]
            for joint in ready:
                poses[joint.child] = poses[joint.parent] @ joint.origin @ _motion(joint, positions.get(joint.name, 0.0))
            waiting = [j for j in waiting if j.child not in poses]
            if not ready:
                break
        home = np.linalg.inv(poses.get(base, np.eye(4)))
        ends, radii = [], []
        for link, pose in poses.items():
            place = home @ pose
            for start, end, radius in self.shapes.get(link, ()):
                ends.append([place[:3, :3] @ p + place[:3, 3] for p in (start, end)])
                radii.append(radius)
            for joint in self.joints:
                if joint.parent == link and link != self.root:
                    ends.append([place[:3, 3], (home @ poses[joint.child])[:3, 3]])
                    radii.append(USUAL_RADIUS)
        return Rods(np.array(ends), np.array(radii))


def _motion(joint: Joint, value: float) -> Matrix:
    """(4, 4) of a joint at a position."""
    moved = np.eye(4)
    if joint.kind in TURNING:
        x, y, z = joint.axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        moved[:3, :3] += math.sin(value) * cross + (1 - math.cos(value)) * cross @ cross
    elif joint.kind == SLIDING:
        moved[:3, 3] = value * joint.axis
    return moved


def parse_description(text: str) -> ArmDescription:
    """An arm from the text of a URDF or an MJCF.

    Raises:
        DescriptionError: it is neither, or has no joint that moves.
    """
    try:
        robot = ET.fromstring(text)
        if robot.tag == "mujoco":
            return _of_mjcf(robot)
        links = [str(link.attrib["name"]) for link in robot.iter("link")]
        joints = tuple(_joint(element) for element in robot.findall("joint"))
        shapes = {str(link.attrib["name"]): _shapes(link) for link in robot.findall("link")}
    except (ET.ParseError, KeyError, ValueError, AttributeError) as error:
        raise DescriptionError(
            f"the robot description is no URDF and no MJCF ({type(error).__name__}: {error}): give the arm's"
        ) from error
    children = {j.child for j in joints}
    roots = [name for name in links if name not in children]
    arm = ArmDescription(roots[0] if roots else "", joints, shapes)
    if not roots or not arm.movable:
        raise DescriptionError(f"the robot description has {len(links)} links and no joint that moves: give the arm's")
    return arm


def _of_mjcf(model: ET.Element) -> ArmDescription:
    read = MjcfReader(model)
    # Where the base stands in the world is not asked: scenes are in its own frame.
    joints = tuple(joint for joint in read.joints if joint.child != read.root)
    arm = ArmDescription(read.root, joints, read.shapes)
    if not arm.movable:
        raise DescriptionError(f"the model has {len(read.shapes)} bodies and no joint that moves: give the arm's")
    return arm


def _numbers(text: str, count: int) -> Matrix:
    """Numbers of an attribute; raises ValueError when they are not ``count`` finite ones."""
    values = np.array([float(word) for word in text.split()])
    if values.shape != (count,) or not np.isfinite(values).all():
        raise ValueError(f"'{text}' is not {count} finite numbers")
    return values


def _origin(element: ET.Element) -> Matrix:
    """(4, 4) of the <origin> of an element."""
    placed = np.eye(4)
    origin = element.find("origin")
    if origin is not None:
        placed[:3, 3] = _numbers(origin.get("xyz", "0 0 0"), 3)
        roll, pitch, yaw = _numbers(origin.get("rpy", "0 0 0"), 3)
        (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (roll, pitch, yaw))
        placed[:3, :3] = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    return placed


def _joint(element: ET.Element) -> Joint:
    """A <joint>."""
    parent, child, axis = (element.find(name) for name in ("parent", "child", "axis"))
    if parent is None or child is None:
        raise ValueError(f"joint '{element.get('name')}' lacks parent or child")
    direction = np.array([1.0, 0.0, 0.0]) if axis is None else _numbers(axis.get("xyz", "1 0 0"), 3)
    direction = direction / max(float(np.linalg.norm(direction)), 1e-9)
    name, kind = str(element.attrib["name"]), str(element.attrib["type"])
    return Joint(name, kind, str(parent.attrib["link"]), str(child.attrib["link"]), _origin(element), direction)


def _shapes(link: ET.Element) -> tuple[tuple[Matrix, Matrix, float], ...]:
    """Cylinders, spheres and boxes of a <link>, as rods along their longest side; meshes tell nothing here."""
    found = []
    elements = link.findall("collision") or link.findall("visual")
    for element in elements:
        cylinder, sphere, box = (element.find(f"geometry/{kind}") for kind in ("cylinder", "sphere", "box"))
        half, radius = np.zeros(3), 0.0
        if cylinder is not None:
            radius, length = float(cylinder.attrib["radius"]), float(cylinder.attrib["length"])
            half[2] = max(0.5 * length - radius, 0.0)
        elif sphere is not None:
            radius = float(sphere.attrib["radius"])
        elif box is not None:
            size = _numbers(box.attrib["size"], 3)
            longest = int(np.argmax(size))
            radius = 0.25 * float(size.sum() - size[longest])
            half[longest] = max(0.5 * float(size[longest]) - radius, 0.0)
        else:
            continue
        place = _origin(element)
        start, end = (place[:3, :3] @ (sign * half) + place[:3, 3] for sign in (-1.0, 1.0))
        found.append((start, end, radius))
    return tuple(found)
