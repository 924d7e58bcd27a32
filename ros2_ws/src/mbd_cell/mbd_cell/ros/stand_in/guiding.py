"""Hand guiding in the cell: the services and topics by which drivers make an arm soft."""

from __future__ import annotations

import time
from typing import Any

from mbd_robot.profiles.guiding import GuidingProfile, GuidingSwitch
from mbd_robot.ros.interfaces import interface
from rclpy.node import Node
from std_msgs.msg import Bool

FREEDRIVE_TIMEOUT = 1.0  # [s] inactive_timeout of UR's freedrive_mode_controller


class StandInGuiding:
    """Knows whether the arm is soft.

    Args:
        node: the server's.
        profile: how the arm is switched.
    """

    def __init__(self, node: Node, profile: GuidingProfile) -> None:
        self._node, self._profile = node, profile
        self._on = profile.switch is GuidingSwitch.PERSON
        self._freed = -1e9
        if profile.switch is GuidingSwitch.KINOVA_FORCE_CONTROL:
            start, stop = (interface("kinova_msgs", "srv", name) for name in ("Start", "Stop"))
            node.create_service(start, profile.enable, lambda _, answer: self._kinova(True, answer))
            node.create_service(stop, profile.disable, lambda _, answer: self._kinova(False, answer))
        if profile.switch in (GuidingSwitch.CONTROLLERS, GuidingSwitch.FREEDRIVE):
            kind = interface("controller_manager_msgs", "srv", "SwitchController")
            node.create_service(kind, "controller_manager/switch_controller", self._switched)
        if profile.switch is GuidingSwitch.FREEDRIVE:
            node.create_subscription(Bool, profile.enable, self._on_freedrive, 10)

    @property
    def soft(self) -> bool:
        """Whether a hand can guide the arm."""
        if self._profile.switch is GuidingSwitch.FREEDRIVE:
            return self._on and time.monotonic() - self._freed < FREEDRIVE_TIMEOUT
        return self._on

    @property
    def refuses(self) -> bool:
        """Whether the arm's action is not served meanwhile."""
        return self._profile.switch is not GuidingSwitch.PERSON and self._on

    def _kinova(self, on: bool, answer: Any) -> Any:
        self._on = on
        if on:
            answer.start_result = "Start force control requested."
        else:
            answer.stop_result = "Stop force control requested."
        return answer

    def _switched(self, request: Any, answer: Any) -> Any:
        soft = self._profile.disable if self._profile.switch is GuidingSwitch.FREEDRIVE else self._profile.enable
        controller = soft.split()[0]
        known = {*self._profile.enable.split(), *self._profile.disable.split()}
        unknown = [n for n in (*request.activate_controllers, *request.deactivate_controllers) if n not in known]
        if unknown:
            answer.ok, answer.message = False, f"no controller named {', '.join(unknown)}"
            return answer
        if controller in request.activate_controllers:
            self._on = True
        if controller in request.deactivate_controllers:
            self._on = False
        answer.ok = True
        return answer

    def _on_freedrive(self, msg: Bool) -> None:
        self._freed = time.monotonic() if msg.data else -1e9
