"""A robot process: tool poses and joint states at a rate, of a hand that closes and opens; prints what it sent."""

from __future__ import annotations

import math
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.ros.conversions import scene_to_msg, time_to_msg
from mbd_model.ros.qos import LATCHED, MOTION
from mbd_msgs.msg import Scene as SceneMsg
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

PERIOD = 14.0  # [s] from one closing to the next
NAMES = [f"j2n6s300_joint_{k}" for k in range(1, 7)] + [f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)]


def main(rate: float, seconds: float) -> None:
    rclpy.init()
    node = Node("bench_arm")
    scenes = node.create_publisher(SceneMsg, "perception/source_scene", LATCHED)
    poses = node.create_publisher(PoseStamped, "j2n6s300_driver/out/tool_pose", MOTION)
    joints = node.create_publisher(JointState, "j2n6s300_driver/out/joint_state", MOTION)
    scenes.publish(scene_to_msg(Scene(Role.SOURCE, (SceneObject("cup", (0.5, 0.0, 0.05), (0.06, 0.06, 0.1)),))))
    start = node.create_client(Trigger, "demonstration/start")
    pose, state = PoseStamped(), JointState(name=NAMES)
    pose.header.frame_id, pose.pose.orientation.w = "j2n6s300_link_base", 1.0

    def send(at: float) -> None:
        phase = at % PERIOD
        finger = min(max(min(phase - 2.0, 8.0 - phase), 0.0), 1.0)
        pose.pose.position.x, pose.pose.position.z = 0.5 + 0.2 * math.sin(at), 0.2 + 0.1 * math.cos(at)
        state.position = [0.1 * at % 1.0] * 6 + [finger] * 3
        pose.header.stamp = state.header.stamp = time_to_msg(time.time())
        poses.publish(pose)
        joints.publish(state)

    others = (scenes, poses, joints)
    while not (all(p.get_subscription_count() for p in others) and start.service_is_ready()):
        rclpy.spin_once(node, timeout_sec=0.05)
    begun = False
    while not begun:
        send(0.0)
        rclpy.spin_once(node, timeout_sec=0.2)  # until the node has taken it, or is asked again
        future = start.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=5.0)
        answer = future.result()
        begun = answer is not None and answer.success
    sys.stdout.write("begun\n")
    sys.stdout.flush()
    first = time.monotonic()
    total = round(rate * seconds)
    for number in range(total):
        # A driver's clock: to the sample's time, not for luck.
        time.sleep(max(0.0, first + number / rate - time.monotonic()))
        send(number / rate)
    sys.stdout.write(f"{total} {time.monotonic() - first:.3f}\n")
    rclpy.shutdown()


if __name__ == "__main__":
    main(float(sys.argv[1]), float(sys.argv[2]))
