"""Has requests done by other nodes without ever blocking: one service call each, watched until it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mbd_model.errors import MbdError
from mbd_model.objects import Scene
from mbd_model.ros.conversions import correction_to_request, scene_from_msg, stamp_from_msg
from mbd_msgs.srv import Observe, ReviseTask
from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from mbd_interaction.effects import Call, Request
from mbd_interaction.events import RequestDone, Signal

PERIOD = 0.1  # [s] between two looks at the requests under way
Answer = Observe.Response | Trigger.Response | ReviseTask.Response
TRIGGERED = (Request.START, Request.STOP, Request.DISCARD)


@dataclass(frozen=True)
class Patience:
    """How long to wait [s]: for a service to be there, and for its answer."""

    service: float
    answer: float


@dataclass
class _Running:
    call: Call
    waited: float = 0.0
    future: Future[Any] | None = None


class RequestRunner:
    """Calls services for a node and reports each request's end as a RequestDone, always, in the node's own thread.

    Args:
        node: whose services these are clients of.
        patience: how long to wait.
        report: takes the RequestDone.
        now: the node's time [ns].
    """

    def __init__(
        self, node: Node, patience: Patience, report: Callable[[RequestDone], None], now: Callable[[], int]
    ) -> None:
        observe = node.create_client(Observe, "perception/observe")
        triggers = {d: node.create_client(Trigger, f"demonstration/{d.name.lower()}") for d in TRIGGERED}
        self._clients: dict[Request, Client[Any, Any]] = {
            Request.OBSERVE_SOURCE: observe,
            Request.OBSERVE_TARGET: observe,
            Request.REVISE: node.create_client(ReviseTask, "demonstration/revise"),
            **triggers,
        }
        self._patience, self._report, self._now = patience, report, now
        self._running: list[_Running] = []
        # Simulated time may stand still just when the service that moves it is missing.
        node.create_timer(PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def run(self, call: Call) -> None:
        """Begin a request."""
        running = _Running(call)
        self._running.append(running)
        self._advance(running)

    def _look(self) -> None:
        for running in list(self._running):
            running.waited += PERIOD
            self._advance(running)

    def _advance(self, running: _Running) -> None:
        client = self._clients[running.call.request]
        package = client.srv_name.split("/")[-2]
        if not client.service_is_ready():
            if running.future is None and running.waited < self._patience.service:
                return
            how = "stopped while it did" if running.future else "is not running:"
            self._end(running, False, f"the {package} node {how} ({client.srv_name}); start it and try again")
        elif running.future is None:
            running.waited = 0.0
            running.future = client.call_async(_request(running.call))
            running.future.add_done_callback(lambda future: self._answered(running, future.result()))
        elif running.waited > self._patience.answer:
            self._end(running, False, f"the {package} node did not answer within {self._patience.answer:.0f} s")

    def _answered(self, running: _Running, response: Answer | None) -> None:
        if response is None:  # cancelled: the request's end was reported, or its patience ends it
            return
        scene, stamp = None, 0
        if isinstance(response, Observe.Response) and response.success:
            try:
                scene, stamp = scene_from_msg(response.scene), stamp_from_msg(response.scene.header.stamp)
            except (MbdError, ValueError) as error:
                self._end(running, False, f"perception answered with a scene that cannot be: {error}")
                return
        self._end(running, response.success, response.message, scene, stamp)

    def _end(self, running: _Running, success: bool, message: str, scene: Scene | None = None, stamp: int = 0) -> None:
        if running not in self._running:
            return  # ended before, by a time-out
        self._running.remove(running)
        if running.call.token is not None:
            self._report(
                RequestDone(
                    Signal.REQUEST_DONE,
                    self._now(),
                    token=running.call.token,
                    success=success,
                    message=message,
                    scene=scene,
                    scene_stamp=stamp,
                )
            )


def _request(call: Call) -> Observe.Request | Trigger.Request | ReviseTask.Request:
    request = call.request
    if call.correction is not None:
        return correction_to_request(call.correction)
    if request is Request.OBSERVE_SOURCE:
        return Observe.Request(role=Observe.Request.SOURCE)
    if request is Request.OBSERVE_TARGET:
        return Observe.Request(role=Observe.Request.TARGET)
    return Trigger.Request()
