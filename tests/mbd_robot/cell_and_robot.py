"""The cell and the robot node in this process, and a client of what the suite receives and sends."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped
from mbd_cell.ros.cell_node import CellNode
from mbd_model.ros.qos import SENSOR
from mbd_msgs.action import MoveGripper, MoveTool
from mbd_robot.ros.robot_node import RobotNode
from mbd_robot.topics import JOINT_STATE, MOVE_GRIPPER, MOVE_TOOL, TOOL_POSE
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

LIMIT = 150.0  # [s] of the wall clock, for a condition to come true


class Playground:
    """Spins what is in it, and lets the cell's time pass."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, args=[], domain_id=domain)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.node = Node("client", context=self.context)
        self.nodes: list[Any] = []
        self.cell: CellNode | None = None
        self.add(self.node)
        self.received: dict[str, Any] = {}
        for kind, topic in ((PoseStamped, TOOL_POSE), (JointState, JOINT_STATE)):
            self.node.create_subscription(kind, topic, lambda m, t=topic: self.received.__setitem__(t, m), SENSOR)
        self.tool = ActionClient(self.node, MoveTool, MOVE_TOOL)
        self.hand = ActionClient(self.node, MoveGripper, MOVE_GRIPPER)

    def add(self, node: Any) -> Any:
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def start_cell(self, robot: str) -> CellNode:
        self.cell = self.add(CellNode(**self.options(robot=robot, speed=0.0, teacher="none")))
        return self.cell

    def start_robot(self, robot: str, *, sim_time: bool = True) -> RobotNode:
        return self.add(RobotNode(**self.options(robot=robot, use_sim_time=sim_time)))

    def options(self, **parameters: Any) -> dict[str, Any]:
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        return {"context": self.context, "parameter_overrides": overrides, "use_global_arguments": False}

    def until(self, true: Callable[[], bool]) -> None:
        end = time.monotonic() + LIMIT
        while not true():
            assert time.monotonic() < end, f"not in {LIMIT:g} s; received {sorted(self.received)}"
            if self.cell is not None:
                self.cell.advance()
            self.executor.spin_once(timeout_sec=0.002)

    def sent(self, client: ActionClient[Any, Any, Any], goal: Any) -> Any:
        """The handle of a goal, whether it was accepted or not."""
        self.until(client.server_is_ready)
        accepted = client.send_goal_async(goal)
        self.until(accepted.done)
        return accepted.result()

    def asked(self, client: ActionClient[Any, Any, Any], goal: Any) -> Any:
        """The result of a goal, None where it was refused."""
        handle = self.sent(client, goal)
        if not handle.accepted:
            return None
        result = handle.get_result_async()
        self.until(result.done)
        return result.result().result

    def goal(self, x: float, y: float, z: float, yaw: float = 0.0) -> Any:
        goal = MoveTool.Goal(speed=0.25)
        goal.target.pose.position.x, goal.target.pose.position.y, goal.target.pose.position.z = x, y, z
        q = goal.target.pose.orientation
        q.x, q.y, q.z, q.w = math.cos(yaw / 2), math.sin(yaw / 2), 0.0, 0.0
        return goal

    def move(self, x: float, y: float, z: float, yaw: float = 0.0) -> Any:
        return self.asked(self.tool, self.goal(x, y, z, yaw))

    def grip(self, command: int) -> Any:
        return self.asked(self.hand, MoveGripper.Goal(command=command))

    def call(self, kind: Any, name: str, request: Any) -> Any:
        """The answer of a service."""
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready)
        asked = client.call_async(request)
        self.until(asked.done)
        return asked.result()

    def close(self) -> None:
        self.executor.shutdown()
        if self.cell is not None:
            self.cell.close()
        for node in self.nodes:
            node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@contextmanager
def playground(domain: int) -> Iterator[Playground]:
    made = Playground(domain)
    try:
        yield made
    finally:
        made.close()


@contextmanager
def played(domain: int, robot: str) -> Iterator[Playground]:
    """The cell plays this robot, and the robot node has received from it."""
    with playground(domain) as made:
        made.start_cell(robot)
        made.start_robot(robot)
        made.until(lambda: len(made.received) == 2)
        yield made
