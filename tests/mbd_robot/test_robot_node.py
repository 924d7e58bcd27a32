"""The robot node and the camera node against the cell, which plays each driver: real messages, real actions."""

from __future__ import annotations

import math
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy
from ament_index_python.packages import get_package_prefix
from cell_and_robot import played
from geometry_msgs.msg import PoseStamped
from mbd_model.ros.qos import EVENTS, SENSOR
from mbd_model.ros.stop_line import StopLine
from mbd_model.stop import StopCause
from mbd_msgs.action import MoveGripper, MoveTool
from mbd_msgs.msg import WizardGripper
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image, JointState
from std_srvs.srv import SetBool

LIMIT = 60.0  # [s]


@contextmanager
def process(package: str, executable: str, log: Path, **parameters: object) -> Iterator[subprocess.Popen[bytes]]:
    words = [str(Path(get_package_prefix(package)) / "lib" / package / executable), "--ros-args"]
    words += [w for name, value in parameters.items() for w in ("-p", f"{name}:={value}")]
    with log.open("w") as out:
        running = subprocess.Popen(words, stdout=out, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            yield running
        finally:
            running.send_signal(2)
            try:
                running.wait(10.0)
            except subprocess.TimeoutExpired:
                running.kill()
                running.wait()


class Client:
    """What execution and perception would receive and send."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, args=[], domain_id=domain)
        self.node = Node("client", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.received: dict[str, Any] = {}
        for kind, topic in (
            (PoseStamped, "robot/out/tool_pose"),
            (JointState, "robot/out/joint_state"),
            (Image, "camera/color/image_raw"),
            (Image, "camera/depth/image_raw"),
            (CameraInfo, "camera/color/camera_info"),
        ):
            self.node.create_subscription(kind, topic, lambda m, t=topic: self.received.__setitem__(t, m), SENSOR)
        self.tool = ActionClient(self.node, MoveTool, "robot/move_tool")
        self.hand = ActionClient(self.node, MoveGripper, "robot/move_gripper")

    def until(self, true: Callable[[], bool]) -> bool:
        end = time.monotonic() + LIMIT
        while not true() and time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)
        return true()

    def ask(self, client: ActionClient[Any, Any, Any], goal: Any) -> Any:
        assert self.until(client.server_is_ready)
        accepted = client.send_goal_async(goal)
        assert self.until(accepted.done)
        handle = accepted.result()
        if not handle.accepted:
            return None
        result = handle.get_result_async()
        assert self.until(result.done)
        return result.result().result

    def move(self, x: float, y: float, z: float, yaw: float) -> Any:
        goal = MoveTool.Goal(speed=0.25)
        goal.target.header.frame_id = self.received["robot/out/tool_pose"].header.frame_id
        goal.target.pose.position.x, goal.target.pose.position.y, goal.target.pose.position.z = x, y, z
        q = goal.target.pose.orientation
        q.x, q.y, q.z, q.w = math.cos(yaw / 2), math.sin(yaw / 2), 0.0, 0.0
        return self.ask(self.tool, goal)

    def grip(self, command: int) -> Any:
        return self.ask(self.hand, MoveGripper.Goal(command=command))

    def close(self) -> None:
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@contextmanager
def playing(domain: int, folder: Path, robot: str, camera: str) -> Iterator[Client]:
    with ExitStack() as stack:
        stack.enter_context(pytest.MonkeyPatch.context()).setenv("ROS_DOMAIN_ID", str(domain))
        cell = {"robot": robot, "camera": camera, "speed": 0.0, "teacher": "none"}
        stack.enter_context(process("mbd_cell", "cell", folder / "cell.log", **cell))
        stack.enter_context(process("mbd_robot", "robot", folder / "robot.log", robot=robot, use_sim_time=True))
        stack.enter_context(process("mbd_robot", "camera", folder / "camera.log", camera=camera, use_sim_time=True))
        client = Client(domain)
        stack.callback(client.close)
        assert client.until(lambda: len(client.received) == 5), sorted(client.received)
        yield client


@pytest.mark.parametrize(
    ("robot", "camera", "closed"),
    [
        ("jaco2", "two_topics", 1.314),
        ("fr3", "azure_kinect", 0.0),
        ("gen3", "zed", 0.8),
    ],
)
def test_the_suite_s_goals_are_done_in_the_driver_s_words(
    ros_domain: int, tmp_path: Path, robot: str, camera: str, closed: float
):
    """Kinova's poses and finger ticks; Franka's shrinking fingers on a topic of their own; trajectories, a 2F-85."""
    with playing(ros_domain, tmp_path, robot, camera) as client:
        for goal in ((0.4, -0.12, 0.3, 0.0), (0.45, 0.1, 0.25, 0.6)):
            result = client.move(*goal)
            assert result.success, result.message
            p = result.reached.position
            assert math.dist((p.x, p.y, p.z), goal[:3]) < 0.01
        refused = client.move(2.0, 0.0, 0.2, 0.0)
        assert not refused.success
        assert refused.message
        empty = client.grip(MoveGripper.Goal.CLOSE)
        assert (empty.success, empty.holding) == (True, False), empty.message
        assert client.until(lambda: abs(client.received["robot/out/joint_state"].position[-1] - closed) < 0.05)
        assert client.grip(MoveGripper.Goal.OPEN).success
        assert client.received["camera/depth/image_raw"].encoding in ("16UC1", "32FC1")
        assert client.received["camera/color/image_raw"].width == client.received["camera/depth/image_raw"].width


def test_nothing_moves_while_the_arm_is_guided_by_hand(ros_domain: int, tmp_path: Path):
    with playing(ros_domain, tmp_path, "ur5e", "realsense_compressed") as client:
        assert client.received["camera/color/image_raw"].encoding == "rgb8"
        switch = client.node.create_client(SetBool, "robot/hand_guiding")
        assert client.until(switch.service_is_ready)
        asked = switch.call_async(SetBool.Request(data=True))
        assert client.until(asked.done)
        assert "remote control" in asked.result().message
        # The driver's answer comes after: until then goals are done, then they are refused.
        assert client.until(lambda: client.move(0.4, 0.0, 0.3, 0.0) is None)
        asked = switch.call_async(SetBool.Request(data=False))
        assert client.until(lambda: (done := client.move(0.4, 0.1, 0.3, 0.0)) is not None and done.success)


def test_a_stopped_robot_takes_no_goal_and_moves_no_hand_until_a_person_lets_it_go_on(ros_domain: int):
    with played(ros_domain, "fr3") as there:
        line = StopLine(there.node)
        assert there.grip(MoveGripper.Goal.CLOSE).success
        line.stop(StopCause.EMERGENCY_STOP, "the emergency stop is pressed")
        there.until(lambda: there.move(0.4, 0.0, 0.3) is None)
        words = there.node.create_publisher(WizardGripper, "wizard/gripper", EVENTS)
        there.until(lambda: words.get_subscription_count() > 0)
        closed = there.received["robot/out/joint_state"].position[-1]
        words.publish(WizardGripper(command=WizardGripper.OPEN))
        assert there.grip(MoveGripper.Goal.OPEN) is None
        assert there.received["robot/out/joint_state"].position[-1] == pytest.approx(closed, abs=1e-3)
        line.release()
        there.until(lambda: (done := there.grip(MoveGripper.Goal.OPEN)) is not None and done.success)
        assert there.move(0.4, 0.0, 0.3).error_code == MoveTool.Result.NONE
        assert there.move(2.0, 0.0, 0.3).error_code == MoveTool.Result.NOT_REACHED


def test_a_driver_that_is_gone_is_said_to_be_and_moves_nothing(ros_domain: int, tmp_path: Path):
    with pytest.MonkeyPatch.context() as patch, ExitStack() as stack:
        patch.setenv("ROS_DOMAIN_ID", str(ros_domain))
        log = tmp_path / "robot.log"
        stack.enter_context(process("mbd_robot", "robot", log, robot="gen3"))
        client = Client(ros_domain)
        stack.callback(client.close)
        from diagnostic_msgs.msg import DiagnosticArray

        said: list[str] = []
        client.node.create_subscription(
            DiagnosticArray, "diagnostics", lambda m: said.append(m.status[0].message), EVENTS
        )
        assert client.until(lambda: bool(said))
        assert "no joint state of joint_1" in said[0]
        assert client.grip(MoveGripper.Goal.OPEN) is None


@pytest.mark.parametrize(
    ("executable", "word", "expected"),
    [
        ("robot", "robot:=jaco3", "did you mean 'jaco2'"),
        ("camera", "camera:=nowhere/mine.yaml", "cannot be read"),
        ("robot", "robots:=ur5e", "did you mean 'robot'"),
    ],
)
def test_a_wrong_profile_ends_the_node_with_one_sentence(ros_domain: int, executable: str, word: str, expected: str):
    path = Path(get_package_prefix("mbd_robot")) / "lib" / "mbd_robot" / executable
    done = subprocess.run(
        [str(path), "--ros-args", "-p", word], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert expected in done.stderr
    assert "Traceback" not in done.stderr
