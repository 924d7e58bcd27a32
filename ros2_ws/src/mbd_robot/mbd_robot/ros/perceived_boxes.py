"""Boxes of the objects that perception saw last, for the arm to keep clear of."""

from __future__ import annotations

from mbd_model.errors import MbdError
from mbd_model.objects import SceneObject
from mbd_model.ros.conversions import scene_from_msg
from mbd_model.ros.qos import LATCHED
from mbd_msgs.msg import Scene
from rclpy.node import Node

from mbd_robot.geometry import Obstacle


class PerceivedBoxes:
    """Follows the scenes.

    Args:
        node: that listens.
        heed: False keeps no box.

    Attributes:
        boxes: of the newest scene.
    """

    def __init__(self, node: Node, *, heed: bool) -> None:
        self.boxes: tuple[Obstacle, ...] = ()
        if heed:
            node.create_subscription(Scene, "perception/source_scene", self._on_scene, LATCHED)
            node.create_subscription(Scene, "perception/target_scene", self._on_scene, LATCHED)

    def _on_scene(self, msg: Scene) -> None:
        try:
            scene = scene_from_msg(msg)
        except MbdError:
            return
        self.boxes = tuple(box_of(thing) for thing in scene.objects)


def box_of(thing: SceneObject) -> Obstacle:
    """The box of an object; its size is given across, along and up."""
    across, along, up = thing.size
    return Obstacle(thing.object_id, thing.box_center or thing.centroid, (along, across, up), thing.yaw)
