"""A demonstration node for tests, and in the same process those who talk to it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from mbd_demonstration.ros.node import DemonstrationNode
from mbd_demonstration.samples import Samples
from mbd_demonstration.synthetic import Demonstration
from mbd_model.ros.conversions import scene_to_msg, time_from_msg, time_to_msg
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs.msg import Scene, Task, WizardGripper
from mbd_msgs.srv import ReviseTask
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

BEGIN = 100.0


class Session:
    """A demonstration node and, in the same process, those who talk to it."""

    def __init__(self, domain: int, state_dir: Path, **parameters: object) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        overrides = [Parameter(k, value=v) for k, v in {"state_dir": str(state_dir), **parameters}.items()]
        self._reads_joint = parameters.get("gripper_source") == "joint"
        self.node = DemonstrationNode(context=self.context, parameter_overrides=overrides)
        self.peer = rclpy.create_node("peer", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)
        self.scenes = self.peer.create_publisher(Scene, "perception/source_scene", LATCHED)
        self.poses = self.peer.create_publisher(PoseStamped, "j2n6s300_driver/out/tool_pose", SENSOR)
        self.joints = self.peer.create_publisher(JointState, "j2n6s300_driver/out/joint_state", SENSOR)
        self.words = self.peer.create_publisher(WizardGripper, "wizard/gripper", EVENTS)
        self.names = [f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)]
        self.tasks: list[Task] = []
        self.peer.create_subscription(Task, "demonstration/task", self.tasks.append, LATCHED)
        self.until(lambda: all(p.get_subscription_count() for p in (self.scenes, self.poses, self.joints, self.words)))

    def until(self, done: Callable[[], bool], seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if done():
                return
            self.executor.spin_once(timeout_sec=0.02)
        pytest.fail("waited in vain")

    def tool_is_there(self) -> None:
        """The driver publishes a tool pose, as it does all the time: nothing can be recorded without."""
        before = self.node.last_pose
        while self.node.last_pose == before:
            pose = PoseStamped()
            pose.header.frame_id = "j2n6s300_link_base"
            pose.header.stamp, pose.pose.orientation.w = time_to_msg(BEGIN - 50.0), 1.0
            self.poses.publish(pose)
            self.executor.spin_once(timeout_sec=0.05)

    def ask(self, request: str) -> Trigger.Response:
        if request == "start":
            self.tool_is_there()
        return self.call(request)

    def call(self, request: str) -> Trigger.Response:
        """Ask at once, whether the driver is there or not."""
        client = self.peer.create_client(Trigger, f"demonstration/{request}")
        self.until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.until(future.done)
        return future.result()

    def revise(self, **change: Any) -> ReviseTask.Response:
        client = self.peer.create_client(ReviseTask, "demonstration/revise")
        self.until(client.service_is_ready)
        future = client.call_async(ReviseTask.Request(**change))
        self.until(future.done)
        return future.result()

    def show(self, shown: Demonstration) -> None:
        """Record it, and wait for its task."""
        before = len(self.tasks)
        self.observe(shown)
        assert self.ask("start").success
        self.play(shown)
        answer = self.ask("stop")
        assert answer.success, answer.message
        self.until(lambda: len(self.tasks) > before)

    def observe(self, shown: Demonstration) -> None:
        self.scenes.publish(scene_to_msg(shown.scene))
        self.until(lambda: self.node.scene is not None)

    def play(self, shown: Demonstration, *, words: bool = True) -> None:
        """Publish the recording as the robot and the wizard would."""
        names = self.names
        for t, p, q, g in zip(shown.stamps, shown.positions, shown.quaternions, shown.joint, strict=True):
            pose = PoseStamped()
            pose.header.stamp, pose.header.frame_id = time_to_msg(float(t)), shown.scene.frame_id
            pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = map(float, p)
            o = pose.pose.orientation
            o.x, o.y, o.z, o.w = map(float, q)
            joints = JointState(header=pose.header, name=names, position=[float(g)] * len(names))
            self._reaches(self.poses, pose, lambda: self.node.recording.poses)
            if self._reads_joint:
                self._reaches(self.joints, joints, lambda: self.node.recording.fingers.get(names[-1]))
        for event in shown.events if words else ():
            word = WizardGripper(command=int(event.action))
            word.header.stamp = time_to_msg(event.stamp)
            self.words.publish(word)
        if words and not self._reads_joint:
            self.until(lambda: len(self.node.recording.events) == len(shown.events))

    def _reaches(
        self, publisher: Publisher, msg: PoseStamped | JointState, arrived: Callable[[], Samples | None]
    ) -> None:
        """Publish until the node has it: sensor data may be lost, and the node leaves a repeated stamp out."""
        stamp = time_from_msg(msg.header.stamp)
        for _ in range(60):
            publisher.publish(msg)
            end = time.monotonic() + 1.0
            while time.monotonic() < end:
                samples = arrived()
                if samples is not None and stamp in samples.table()[-3:, 0]:
                    return
                self.executor.spin_once(timeout_sec=0.02)
        pytest.fail(f"{publisher.topic_name} did not reach the node")

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.peer.destroy_node()
        rclpy.try_shutdown(context=self.context)


def steps_of(task: Task) -> list[tuple[int, str]]:
    return [(s.kind, s.primary_object) for s in task.steps]
