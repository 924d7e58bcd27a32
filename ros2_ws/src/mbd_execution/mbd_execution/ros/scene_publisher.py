"""What the robot at work takes to be on the table and in its hand, published for who moves the arm."""

from __future__ import annotations

from dataclasses import replace

from geometry_msgs.msg import Point, Pose, Quaternion
from mbd_model.objects import SceneObject
from mbd_model.ros.conversions import object_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_msgs.msg import ExecutionScene, ObjectFeatures
from rclpy.node import Node
from std_msgs.msg import Header

from mbd_execution.work.state import Work


class ScenePublisher:
    """Publishes execution/scene whenever it has changed.

    Args:
        node: the publisher's.
        frame: of every coordinate.
    """

    def __init__(self, node: Node, frame: str) -> None:
        self._node, self._frame = node, frame
        self._publisher = node.create_publisher(ExecutionScene, "execution/scene", LATCHED)
        self._last: ExecutionScene | None = None

    def publish(self, work: Work) -> None:
        """Publish what is believed now."""
        msg = execution_scene(work)
        if msg == self._last:
            return
        self._last = execution_scene(work)
        msg.header = Header(stamp=self._node.get_clock().now().to_msg(), frame_id=self._frame)
        self._publisher.publish(msg)


def execution_scene(work: Work) -> ExecutionScene:
    """What stands on the table and what is in the hand, without stamp and frame."""
    carried = work.carried
    loaded = work.table.load(carried.held.box.object_id) if carried else frozenset()
    msg = ExecutionScene(
        objects=[_where_it_is(o) for o in work.others(*loaded)],
        in_hand=[_where_it_is(o) for o in work.table.objects if o.object_id in loaded],
    )
    if carried is not None:
        grasp, (x, y, z, w) = carried.held.grasp, carried.held.grasp.quaternion
        msg.grasp = Pose(position=Point(x=grasp.x, y=grasp.y, z=grasp.z), orientation=Quaternion(x=x, y=y, z=z, w=w))
    return msg


def _where_it_is(thing: SceneObject) -> ObjectFeatures:
    """One object; in the work its centroid is the middle of its box, and ``box_center`` where it was first seen."""
    return object_to_msg(replace(thing, box_center=thing.centroid))
