"""The cell and wizard nodes as processes of their own, over real messages."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from mbd_cell.layout.placement import layout
from mbd_model.objects import Role
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs import msg as m
from mbd_msgs.action import MoveGripper, MoveTool
from mbd_msgs.srv import LayTable
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2
from shipped_scenes import scenes_of


class Bench:
    """Processes under test, and this process's ears."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        self.processes: list[subprocess.Popen[str]] = []
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("bench", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.received: dict[str, list[Any]] = {}

    def listen(self, kind: type, topic: str, qos: Any) -> None:
        """Keep what is reason on a topic."""
        received = self.received.setdefault(topic, [])
        self.node.create_subscription(kind, topic, received.append, qos)

    def start(self, module: str, *parameters: str) -> subprocess.Popen[str]:
        """Start a node."""
        flags = [word for p in parameters for word in ("-p", p)]
        command = [sys.executable, "-m", module, "--ros-args", *flags]
        process = subprocess.Popen(command, env=self.environment, stderr=subprocess.PIPE, text=True)
        self.processes.append(process)
        return process

    def until(self, condition: Callable[[], bool], seconds: float = 240.0) -> None:
        """Spin until it holds; fails after that many seconds."""
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, (
                f"not in {seconds} s; received { ({t: len(v) for t, v in self.received.items()}) }"
            )
            self.executor.spin_once(timeout_sec=0.1)

    def result(self, future: Any) -> Any:
        """The result of a call."""
        self.until(future.done)
        return future.result()

    def close(self) -> None:
        for process in self.processes:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            try:
                process.communicate(timeout=60)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    bench = Bench(ros_domain)
    try:
        yield bench
    finally:
        bench.close()


def test_the_node_publishes_all_a_real_cell_would_and_ends_quietly_on_ctrl_c(bench: Bench) -> None:
    driver = "j2n6s300_driver/out"
    for kind, topic, qos in (
        (Image, "camera/color/image_raw", SENSOR),
        (Image, "camera/depth/image_raw", SENSOR),
        (CameraInfo, "camera/color/camera_info", SENSOR),
        (PointCloud2, "camera/points", SENSOR),
        (PoseStamped, f"{driver}/tool_pose", SENSOR),
        (JointState, f"{driver}/joint_state", SENSOR),
        (Clock, "/clock", 10),
        (m.CellTruth, "cell/truth", LATCHED),
    ):
        bench.listen(kind, topic, qos)
    process = bench.start("mbd_cell.ros.cell_node", "task:=sorting", "seed:=3", "camera_rate:=5.0")
    bench.until(lambda: all(bench.received.values()))
    depth = bench.received["camera/depth/image_raw"][-1]
    millimetres = np.frombuffer(depth.data, np.uint16).reshape(depth.height, depth.width)
    assert depth.encoding == "16UC1"
    # The table fills most of the view, about one metre below the camera.
    assert 950 < np.median(millimetres[millimetres > 0]) < 1060
    points = bench.received["camera/points"][-1]
    cloud = np.frombuffer(points.data, np.float32).reshape(points.height, points.width, 4)
    assert np.nanmedian(cloud[..., 2]) == pytest.approx(1.0, abs=0.06)
    joints = bench.received[f"{driver}/joint_state"][-1]
    assert joints.name[0] == "j2n6s300_joint_1" and joints.name[-1] == "j2n6s300_joint_finger_3"
    truth = bench.received["cell/truth"][-1]
    assert (truth.task, truth.role, len(truth.objects), len(truth.solution)) == ("sorting", 1, 6, 6)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    assert "Traceback" not in errors


def test_the_table_is_laid_and_the_arm_moved_on_request(bench: Bench) -> None:
    bench.listen(m.CellTruth, "cell/truth", LATCHED)
    bench.start("mbd_cell.ros.cell_node", "task:=sorting", "speed:=0.0", "teacher:=none")
    lay = bench.node.create_client(LayTable, "cell/lay_table")
    bench.until(lay.service_is_ready)
    answer = bench.result(lay.call_async(LayTable.Request(task="juggling", role=1, seed=1)))
    assert not answer.success and "juggling" in answer.message
    answer = bench.result(lay.call_async(LayTable.Request(task="assembly", role=2, seed=5)))
    assert answer.success
    bench.until(lambda: any(t.task == "assembly" and t.role == 2 for t in bench.received["cell/truth"]))

    move = ActionClient(bench.node, MoveTool, "cell/move_tool")
    bench.until(move.server_is_ready)
    goal = MoveTool.Goal()
    goal.target.pose.position.x, goal.target.pose.position.z = 0.4, 0.3
    goal.target.pose.orientation.x, goal.target.pose.orientation.w = 1.0, 0.0
    moved = bench.result(bench.result(move.send_goal_async(goal)).get_result_async()).result
    assert moved.success, moved.message
    assert moved.reached.position.x == pytest.approx(0.4, abs=0.01)
    goal.target.pose.position.x = 2.0
    refused = bench.result(bench.result(move.send_goal_async(goal)).get_result_async()).result
    assert not refused.success and "reach" in refused.message

    grip = ActionClient(bench.node, MoveGripper, "cell/move_gripper")
    bench.until(grip.server_is_ready)
    goal = MoveGripper.Goal(command=MoveGripper.Goal.CLOSE)
    closed = bench.result(bench.result(grip.send_goal_async(goal)).get_result_async()).result
    assert closed.success and not closed.holding


def test_with_a_wizard_the_teacher_shows_the_complete_task(bench: Bench) -> None:
    bench.listen(m.Speech, "cell/speech", EVENTS)
    bench.listen(m.WizardGripper, "wizard/gripper", EVENTS)
    bench.start("mbd_cell.ros.cell_node", "task:=lunch_packing", "seed:=2", "speed:=0.0")
    bench.start("mbd_cell.ros.wizard_node")
    state = bench.node.create_publisher(m.SessionState, "interaction/state", LATCHED)
    state.publish(m.SessionState(phase=m.SessionState.DEMONSTRATE))
    words = bench.received["cell/speech"]
    bench.until(lambda: bool(words) and words[-1].word == m.Speech.DEMONSTRATION_ENDS)
    commands = [msg.command for msg in bench.received["wizard/gripper"]]
    assert commands == [m.WizardGripper.CLOSE, m.WizardGripper.OPEN] * (len(scenes_of("lunch_packing").steps) // 2)


def test_a_cell_that_comes_back_into_a_session_continues_at_its_time_with_its_table(bench: Bench) -> None:
    bench.listen(Clock, "/clock", 10)
    bench.listen(m.CellTruth, "cell/truth", LATCHED)
    state = bench.node.create_publisher(m.SessionState, "interaction/state", LATCHED)
    late = m.SessionState(phase=m.SessionState.ASSIST)
    late.header.stamp.sec = 70
    state.publish(late)
    bench.start("mbd_cell.ros.cell_node", "task:=assembly", "seed:=2")
    bench.until(lambda: any(t.role == m.Scene.TARGET for t in bench.received["cell/truth"]))
    bench.until(lambda: any(c.clock.sec >= 70 for c in bench.received["/clock"]))


def test_a_wizard_that_comes_late_still_knows_how_the_source_table_was_laid(bench: Bench) -> None:
    bench.listen(m.WizardHanded, "wizard/handed", EVENTS)
    scenes = scenes_of("sorting")
    for role, code in ((Role.SOURCE, m.Scene.SOURCE), (Role.TARGET, m.Scene.TARGET)):
        seen = m.Scene(role=code)
        for k, place in enumerate(layout(scenes, role, 6)):
            thing = m.ObjectFeatures(id=f"{role.value[0]}{k}", volume=1e-4, class_score=0.5)
            thing.centroid.x, thing.centroid.y, thing.centroid.z = place.x, place.y, 0.05
            thing.size.x = thing.size.y = thing.size.z = 0.05
            seen.objects.append(thing)
        bench.node.create_publisher(m.Scene, f"perception/{role}_scene", LATCHED).publish(seen)
    truth = m.CellTruth(task="sorting", role=m.Scene.TARGET, seed=6)
    for place in layout(scenes, Role.TARGET, 6):
        true = m.ObjectTruth(name=place.name)
        true.pose.position.x, true.pose.position.y = place.x, place.y
        truth.objects.append(true)
    truth.solution = [
        m.AcceptableTargets(source_name=name, target_names=list(right)) for name, right in scenes.solution.items()
    ]
    bench.node.create_publisher(m.CellTruth, "cell/truth", LATCHED).publish(truth)
    bench.node.create_publisher(m.SessionState, "interaction/state", LATCHED).publish(
        m.SessionState(phase=m.SessionState.ASSIST)
    )
    asked = scenes.source[2]
    prompt = m.Prompt(kind=m.Prompt.WHAT_DO_I_USE, source_id="s2")
    bench.node.create_publisher(m.Prompt, "interaction/prompt", LATCHED).publish(prompt)
    bench.start("mbd_cell.ros.wizard_node")
    bench.until(lambda: bool(bench.received["wizard/handed"]))
    given = int(bench.received["wizard/handed"][0].object_id.removeprefix("t"))
    assert scenes.target[given].name in scenes.solution[asked.name]


@pytest.mark.parametrize(
    ("parameter", "reason"),
    [("task:=juggling", "sorting"), ("teacher:=robot", "scripted"), ("camera_position:=[0.0, 0.0]", "camera")],
)
def test_a_parameter_that_cannot_be_used_ends_the_node_with_a_reason(bench: Bench, parameter: str, reason: str) -> None:
    process = bench.start("mbd_cell.ros.cell_node", parameter)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 1
    assert reason in errors
    assert "Traceback" not in errors
