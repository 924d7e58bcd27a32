"""What is in the hand, told to MoveIt 2: boxes attached to the tip, so that its plans keep them clear as well."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Pose
from mbd_model.errors import MbdError
from rclpy.node import Node
from rclpy.qos import QoSProfile
from scipy.spatial.transform import Rotation

from mbd_robot.geometry import HeldBoxes, Obstacle, RobotToolPose
from mbd_robot.profiles.robot import RobotProfile
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.tool_frames import driver_pose, pose_to_msg

# A MoveGroup monitors it (moveit_cpp.cpp, startSceneMonitor). The robot state within a MoveGroup goal it ignores
# (move_action_capability.cpp: "Execution of motions should always start at the robot's current state").
TOPIC = "planning_scene"
# [m] by which a held box is smaller on each side: it stands on something when it is taken and set down, and what is
# measured is no more exact. An arm that "touches something where it is" is not moved at all.
SLACK = 0.005


class HeldInMoveIt:
    """Attaches and detaches boxes.

    Args:
        node: the publisher's.
        profile: with a section moveit.
    """

    def __init__(self, node: Node, profile: RobotProfile) -> None:
        if profile.arm.moveit is None:
            raise MbdError(f"{profile.title} has no section moveit")
        self._profile, self._links = profile, profile.arm.moveit.touch_links
        self._told = HeldBoxes()
        self._scenes: Any = None
        if self._links:
            kind = interface("moveit_msgs", "msg", "PlanningScene")
            self._scenes = node.create_publisher(kind, TOPIC, QoSProfile(depth=10))
        else:
            node.get_logger().warning(
                "MoveIt is not told what is held: moveit.touch_links of the profile is empty; list the hand's links"
            )

    def tell(self, held: HeldBoxes) -> None:
        """Have MoveIt know what is held now; nothing is sent where it knows."""
        if self._scenes is None or held.boxes == self._told.boxes:
            return
        scene = interface("moveit_msgs", "msg", "PlanningScene")()
        scene.is_diff = scene.robot_state.is_diff = True
        attached = scene.robot_state.attached_collision_objects
        for box in self._told.boxes:
            attached.append(self._attached(box.name, [], []))
            # What is detached becomes part of the world: perception says where it is, not this.
            scene.world.collision_objects.append(self._object(box.name, [], []))
        if held.grasp is not None:
            tip = driver_pose(held.grasp, self._profile.tool_pose)
            for box in held.boxes:
                attached.append(self._attached(box.name, [self._shape(box)], [in_tip(box, tip)]))
        self._told = held
        self._scenes.publish(scene)

    def _attached(self, name: str, shapes: list[Any], poses: list[Pose]) -> Any:
        made = interface("moveit_msgs", "msg", "AttachedCollisionObject")()
        made.link_name, made.touch_links = self._profile.arm.tip, list(self._links)
        made.object = self._object(name, shapes, poses)
        return made

    def _object(self, name: str, shapes: list[Any], poses: list[Pose]) -> Any:
        """A box where there is a shape; else one that goes."""
        made = interface("moveit_msgs", "msg", "CollisionObject")()
        made.header.frame_id, made.id = self._profile.arm.tip, f"held_{name}"
        made.operation = made.ADD if shapes else made.REMOVE
        made.primitives, made.primitive_poses = shapes, poses
        made.pose.orientation.w = 1.0
        return made

    def _shape(self, box: Obstacle) -> Any:
        solid = interface("shape_msgs", "msg", "SolidPrimitive")
        return solid(type=solid.BOX, dimensions=[max(0.001, float(side) - 2.0 * SLACK) for side in box.size])


def in_tip(box: Obstacle, tip: RobotToolPose) -> Pose:
    """Where a box is in the tip's frame; both are given in the base frame."""
    back = tip.rotation.inv()
    turned = back * Rotation.from_euler("z", box.yaw)
    return pose_to_msg(RobotToolPose(back.apply(box.centre - tip.position), turned.as_quat()))
