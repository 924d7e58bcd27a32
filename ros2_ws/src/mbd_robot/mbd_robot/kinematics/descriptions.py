"""An arm's description as a MuJoCo spec: one of ours, an MJCF, or a URDF without its meshes."""

from __future__ import annotations

from xml.etree import ElementTree

import mujoco
from mbd_model.errors import MbdError

from mbd_robot.model_files import MODELS, model_file


class ModelError(MbdError):
    """A description of an arm that cannot be used."""


def load_description(model: str, text: str = "") -> mujoco.MjSpec:
    """The arm that a profile names.

    Args:
        model: a name of ``mbd_robot/models``, or the path of a URDF or MJCF.
        text: the description itself, where a topic gave it.

    Raises:
        ModelError: no such file, or one that is no arm.
    """
    if not text:
        file = model_file(model)
        if not file.is_file():
            names = ", ".join(sorted(f.stem for f in MODELS.glob("*.xml")))
            raise ModelError(f"no model '{model}': expected one of {names}, or the path of a URDF or MJCF")
        text = file.read_text(encoding="utf-8")
    try:
        root = ElementTree.fromstring(text)
        if root.tag == "robot":
            text = _without_meshes(root)
        return mujoco.MjSpec.from_string(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise ModelError(f"the description '{model}' cannot be read: {error}; expected a URDF or an MJCF") from error


def _without_meshes(robot: ElementTree.Element) -> str:
    """A URDF for kinematics only: its meshes lie in packages that need not be here."""
    for link in robot.iter("link"):
        for part in [p for p in link if p.tag in ("visual", "collision")]:
            link.remove(part)
    for extension in [e for e in robot if e.tag in ("gazebo", "ros2_control", "transmission", "mujoco")]:
        robot.remove(extension)
    # MuJoCo would join links that do not move, and with them lose the one the tool is fixed to.
    options = ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler")
    options.set("fusestatic", "false")
    options.set("balanceinertia", "true")
    options.set("boundmass", "0.001")
    options.set("boundinertia", "0.000001")
    return ElementTree.tostring(robot, encoding="unicode")
