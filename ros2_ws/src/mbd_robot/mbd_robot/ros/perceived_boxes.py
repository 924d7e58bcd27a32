"""Boxes of the objects around the arm and in its hand: as perception saw them, and as the robot at work moves them."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.errors import MbdError
from mbd_model.objects import SceneObject
from mbd_model.ros.conversions import object_from_msg, scene_from_msg, stamp_from_msg
from mbd_model.ros.qos import LATCHED
from mbd_msgs.msg import ExecutionScene, Scene
from rclpy.node import Node

from mbd_robot.geometry import HeldBoxes, Obstacle, Surroundings
from mbd_robot.ros.tool_frames import pose_from_msg


class PerceivedBoxes:
    """Follows the scenes.

    Args:
        node: that listens.
        always: boxes that are there whatever is seen.
        heed: False takes nothing that is seen for a box.
    """

    def __init__(self, node: Node, always: tuple[Obstacle, ...], *, heed: bool) -> None:
        self._always, self._last = always, Surroundings()
        self._executed = 0
        self._seen: set[int] = set()
        if heed:
            node.create_subscription(Scene, "perception/source_scene", self._on_scene, LATCHED)
            node.create_subscription(Scene, "perception/target_scene", self._on_scene, LATCHED)
            node.create_subscription(ExecutionScene, "execution/scene", self._on_execution, LATCHED)

    def now(self) -> Surroundings:
        """As the newest message has it, whoever it is from."""
        # The others last: of more boxes than the arm's model has room for, the last are left out.
        return replace(self._last, obstacles=(*self._always, *self._last.obstacles))

    def _on_scene(self, msg: Scene) -> None:
        try:
            scene = scene_from_msg(msg)
        except MbdError:
            return
        # Of what was latched before this node was started, either may come last.
        late = msg.role not in self._seen and stamp_from_msg(msg.header.stamp) < self._executed
        self._seen.add(msg.role)
        if not late:
            self._last = Surroundings(tuple(box_of(thing) for thing in scene.objects))

    def _on_execution(self, msg: ExecutionScene) -> None:
        try:
            around, held = ([box_of(object_from_msg(o)) for o in objects] for objects in (msg.objects, msg.in_hand))
        except MbdError:
            return
        self._executed = stamp_from_msg(msg.header.stamp)
        grasp = pose_from_msg(msg.grasp) if held else None
        self._last = Surroundings(tuple(around), HeldBoxes(tuple(held), grasp))


def box_of(thing: SceneObject) -> Obstacle:
    """The box of an object; its size is given across, along and up."""
    across, along, up = thing.size
    return Obstacle(thing.object_id, thing.box_center or thing.centroid, (along, across, up), thing.yaw)
