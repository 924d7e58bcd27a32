"""Hand guiding switched on and off in the driver's words."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mbd_model.ros.patient_call import call_within
from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Bool

from mbd_robot.profiles.guiding import GuidingProfile, GuidingSwitch
from mbd_robot.ros.interfaces import interface

PATIENCE = 5.0  # [s] until a service that does not answer is given up
FREEDRIVE_PERIOD = 0.4  # [s] the controller wants it at least every half second

# Takes whether it went well, and what to tell people.
GuidingAnswered = Callable[[bool, str], None]


class GuidingControl:
    """Makes the arm soft, and stiff again.

    Args:
        node: the client's.
        profile: how.

    Attributes:
        guided: the driver has said that the arm is soft, or a person was asked to make it so.
    """

    def __init__(self, node: Node, profile: GuidingProfile) -> None:
        self._node, self._profile = node, profile
        self.guided = False
        self._kinova: dict[bool, Client[Any, Any]] = {}
        self._switch: Client[Any, Any] | None = None
        if profile.switch is GuidingSwitch.KINOVA_FORCE_CONTROL:
            start, stop = (interface("kinova_msgs", "srv", name) for name in ("Start", "Stop"))
            self._requests = {True: start.Request, False: stop.Request}
            self._kinova = {
                True: node.create_client(start, profile.enable),
                False: node.create_client(stop, profile.disable),
            }
        if profile.switch in (GuidingSwitch.CONTROLLERS, GuidingSwitch.FREEDRIVE):
            kind = interface("controller_manager_msgs", "srv", "SwitchController")
            self._switch = node.create_client(kind, "controller_manager/switch_controller")
        if profile.switch is GuidingSwitch.FREEDRIVE:
            self._freedrive = node.create_publisher(Bool, profile.enable, 10)
            self._timer = node.create_timer(
                FREEDRIVE_PERIOD, self._keep_free, clock=Clock(clock_type=ClockType.STEADY_TIME)
            )

    def set(self, on: bool, answered: GuidingAnswered) -> None:
        """Switch it; ``answered`` is called once."""
        profile = self._profile

        def done(success: bool, message: str) -> None:
            if success:
                self.guided = on
                if on and profile.instruction:
                    message = f"{message}; {profile.instruction}"
            answered(success, message)

        if profile.switch is GuidingSwitch.PERSON:
            done(True, f"by hand: {profile.instruction}" if on else "by hand: make the arm ready for its driver again")
        elif profile.switch is GuidingSwitch.KINOVA_FORCE_CONTROL:
            words = "force control is on" if on else "force control is off"
            self._call(self._kinova[on], self._requests[on](), lambda _: (True, words), done)
        else:
            self._switch_controllers(on, done)

    def _switch_controllers(self, on: bool, done: GuidingAnswered) -> None:
        client = self._switch
        if client is None:
            return
        soft, stiff = self._profile.enable.split(), self._profile.disable.split()
        if self._profile.switch is GuidingSwitch.FREEDRIVE:
            soft, stiff = stiff[:1], stiff[1:]
            self._freedrive.publish(Bool(data=on))
        request = interface("controller_manager_msgs", "srv", "SwitchController").Request()
        request.activate_controllers, request.deactivate_controllers = (soft, stiff) if on else (stiff, soft)
        request.strictness, request.activate_asap = request.STRICT, True
        names = " ".join(request.activate_controllers)

        def judged(response: Any) -> tuple[bool, str]:
            if response.ok:
                return True, f"{names} is active"
            return False, f"the controller manager did not activate {names}: {response.message or 'is it loaded?'}"

        self._call(client, request, judged, done)

    def _call(
        self, client: Client[Any, Any], request: Any, judged: Callable[[Any], tuple[bool, str]], done: GuidingAnswered
    ) -> None:
        name = client.srv_name
        if not client.service_is_ready():
            done(False, f"nobody serves {name}: is the arm's driver running?")
            return

        def answered(response: Any) -> None:
            if response is None:
                done(False, f"{name} did not answer within {PATIENCE:g} s")
            else:
                done(*judged(response))

        call_within(self._node, client, request, PATIENCE, answered)

    def _keep_free(self) -> None:
        if self.guided:
            self._freedrive.publish(Bool(data=True))
