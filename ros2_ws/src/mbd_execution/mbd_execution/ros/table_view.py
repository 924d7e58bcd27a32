"""Looks at the table through perception's service: one request at a time, given up when no answer comes."""

from __future__ import annotations

from collections.abc import Callable

from mbd_model.errors import MbdError
from mbd_model.ros.conversions import scene_from_msg
from mbd_model.stop import MotionError
from mbd_msgs.srv import Observe
from rclpy.node import Node
from rclpy.task import Future

from mbd_execution.goals import Ended

PATIENCE = 15.0  # [s] until an answer that has not come is taken for lost
ABSENT = 5.0  # [s] until a service nobody offers is given up


class TableView:
    """A client of perception, which publishes nothing of these looks.

    Args:
        node: whose client it is.
        service: name of the service.
        ended: called with how a look ended.

    Attributes:
        looking: a look is under way.
    """

    def __init__(self, node: Node, service: str, ended: Callable[[Ended], None]) -> None:
        self._client = node.create_client(Observe, service)
        self._service, self._ended = service, ended
        self._number, self._begun, self._asked = 0, 0.0, False
        self.looking = False

    def start(self, now: float) -> None:
        """Look; ``now`` [s] of a clock that never stands still."""
        self.looking, self._begun, self._asked = True, now, False
        self._number += 1
        self._ask()

    def look_after(self, now: float) -> None:
        """Do something about an answer that does not come; call it now and then."""
        if not self.looking:
            return
        if not self._asked:
            self._ask()
        waited = now - self._begun
        if waited > PATIENCE:
            self._end(Ended(False, message=f"'{self._service}' does not answer", error=MotionError.NOT_REACHED))
        elif not self._asked and waited > ABSENT:
            why = f"nobody serves '{self._service}': is perception running?"
            self._end(Ended(False, message=why, error=MotionError.NOT_REACHED))

    def forget(self) -> None:
        """Wait for the look under way no longer."""
        self._number += 1
        self.looking = False

    def _ask(self) -> None:
        if not self._client.service_is_ready():
            return
        self._asked, number = True, self._number
        future = self._client.call_async(Observe.Request(role=Observe.Request.TARGET, answer_only=True))
        future.add_done_callback(lambda done: self._answered(number, done))

    def _answered(self, number: int, done: Future[Observe.Response]) -> None:
        response = done.result()
        if number != self._number or not self.looking or response is None:
            return
        if not response.success:
            self._end(Ended(False, message=response.message, error=MotionError.NOT_REACHED))
            return
        try:
            scene = scene_from_msg(response.scene)
        except (MbdError, ValueError) as error:
            why = f"perception answered with a scene that cannot be: {error}"
            self._end(Ended(False, message=why, error=MotionError.NOT_REACHED))
            return
        self._end(Ended(True, seen=scene))

    def _end(self, ended: Ended) -> None:
        self.looking = False
        self._ended(ended)
