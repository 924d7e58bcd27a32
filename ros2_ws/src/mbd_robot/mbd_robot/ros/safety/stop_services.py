"""The driver's own stop and start, called with the suite's stop."""

from __future__ import annotations

from typing import Any

from mbd_model.ros.patient_call import call_within
from rclpy.client import Client
from rclpy.node import Node

from mbd_robot.profiles.robot import ArmProfile
from mbd_robot.ros.interfaces import interface

PATIENCE = 2.0  # [s] until an answer that does not come is said to be missing


class StopServices:
    """Calls the services that a profile names; none where it names none.

    Args:
        node: the client's.
        arm: with the names of its services.
    """

    def __init__(self, node: Node, arm: ArmProfile) -> None:
        self._node = node
        self._clients: dict[bool, Client[Any, Any]] = {}
        if arm.stop_service:
            stop, start = (interface("kinova_msgs", "srv", name) for name in ("Stop", "Start"))
            self._requests = {True: stop.Request, False: start.Request}
            self._clients = {
                True: node.create_client(stop, arm.stop_service),
                False: node.create_client(start, arm.start_service),
            }

    def call(self, stop: bool) -> None:
        """Have the driver stop, or start again; an answer that does not come is logged."""
        client = self._clients.get(stop)
        if client is None:
            return
        name = client.srv_name
        if not client.service_is_ready():
            self._node.get_logger().error(f"nobody serves {name}: use the arm's own emergency stop")
            return

        def answered(response: Any) -> None:
            if response is None:
                self._node.get_logger().error(f"{name} did not answer within {PATIENCE:g} s")

        call_within(self._node, client, self._requests[stop](), PATIENCE, answered)
