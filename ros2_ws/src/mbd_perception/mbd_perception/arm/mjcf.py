"""An arm's description in MuJoCo's format (MJCF), as joints and shapes; its meshes and defaults tell nothing here."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mbd_perception.arm.joint import Joint

Matrix = NDArray[np.float64]
Rod = tuple[Matrix, Matrix, float]
KINDS = {"hinge": "revolute", "slide": "prismatic"}
ROOT = "world"


class MjcfReader:
    """Reads one model.

    Args:
        model: the element <mujoco>.

    Attributes:
        joints: from the base on; bodies without one are fixed.
        shapes: by body, (from, to, radius) of its simple shapes [m, frame of the body].

    Raises:
        ValueError: a number is none.
    """

    def __init__(self, model: ET.Element) -> None:
        compiler = model.find("compiler")
        given = {} if compiler is None else compiler.attrib
        # MuJoCo's own defaults: degrees, and turns about the axes as they turn.
        self._to_radians = 1.0 if given.get("angle", "degree") == "radian" else math.pi / 180.0
        self._sequence = given.get("eulerseq", "xyz")
        self.joints: list[Joint] = []
        self.shapes: dict[str, tuple[Rod, ...]] = {}
        for world in model.findall("worldbody"):
            self._read(world, ROOT)

    @property
    def root(self) -> str:
        """The first body, in whose frame the arm stands; "" of an empty model."""
        return next((joint.child for joint in self.joints if joint.parent == ROOT), "")

    def _read(self, parent: ET.Element, name: str) -> None:
        for number, body in enumerate(parent.findall("body")):
            child = body.get("name", f"{name}/{number}")
            self.joints += self._joints(body, name, child)
            self.shapes[child] = tuple(self._shapes(body))
            self._read(body, child)

    def _joints(self, body: ET.Element, parent: str, child: str) -> Iterator[Joint]:
        origin, found = self._placed(body), body.find("joint")
        if found is None:
            yield Joint("", "fixed", parent, child, origin, np.array((1.0, 0.0, 0.0)))
            return
        kind = KINDS.get(found.get("type", "hinge"), "fixed")
        axis = _numbers(found.get("axis", "0 0 1"), 3)
        axis /= max(float(np.linalg.norm(axis)), 1e-9)
        yield Joint(found.get("name", child), kind, parent, child, origin, axis)

    def _placed(self, element: ET.Element) -> Matrix:
        """(4, 4) of an element in its parent."""
        made = np.eye(4)
        made[:3, 3] = _numbers(element.get("pos", "0 0 0"), 3)
        quat, euler = element.get("quat"), element.get("euler")
        if quat is not None:
            w, x, y, z = _numbers(quat, 4)
            made[:3, :3] = Rotation.from_quat((x, y, z, w)).as_matrix()
        elif euler is not None:
            # Capitals are axes that stand still, as scipy's small letters are.
            turns = self._to_radians * _numbers(euler, 3)
            made[:3, :3] = Rotation.from_euler(self._sequence.swapcase(), turns).as_matrix()
        return made

    def _shapes(self, body: ET.Element) -> Iterator[Rod]:
        for geom in body.findall("geom"):
            fromto, size = geom.get("fromto"), _numbers(geom.get("size", "0"), None)
            if fromto is not None:
                ends = _numbers(fromto, 6)
                yield ends[:3], ends[3:], float(size[0])
                continue
            kind, half, radius = geom.get("type", "sphere"), np.zeros(3), float(size[0])
            if kind in ("capsule", "cylinder") and len(size) > 1:
                half[2] = float(size[1])
            elif kind == "box" and len(size) == 3:
                longest = int(np.argmax(size))
                radius = 0.5 * float(size.sum() - size[longest])
                half[longest] = max(float(size[longest]) - radius, 0.0)
            elif kind != "sphere":
                continue
            if radius > 0.0:
                place = self._placed(geom)
                yield place[:3, :3] @ -half + place[:3, 3], place[:3, :3] @ half + place[:3, 3], radius


def _numbers(text: str, count: int | None) -> Matrix:
    values = np.array([float(word) for word in text.split()])
    if (count is not None and values.shape != (count,)) or not np.isfinite(values).all() or not len(values):
        raise ValueError(f"'{text}' is not {count or 'some'} finite numbers")
    return values
