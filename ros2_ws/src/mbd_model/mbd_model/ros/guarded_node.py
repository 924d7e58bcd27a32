"""A node that nothing sent to it can end: what one of its callbacks cannot take is logged, counted and ignored.

A message that fits its type may still hold what no code foresaw: an enumeration's value nobody knows, a quaternion of
zeros, a list of names that do not exist. A latched one would end its node again at each restart.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from functools import wraps
from inspect import iscoroutinefunction
from typing import Any

from rclpy._rclpy_pybind11 import RCLError
from rclpy.clock import Clock as RosClock
from rclpy.exceptions import InvalidHandle, NotInitializedException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.time_source import TimeSource

from mbd_model.ros.bad_messages import BadMessages
from mbd_model.ros.polling.simulated_time import SimulatedTime
from mbd_model.ros.polling.subscriptions import UnwaitedGroup

# Not what was sent: the context was shut down meanwhile.
_OVER = (ExternalShutdownException, RCLError, NotInitializedException, InvalidHandle)


class GuardedNode(Node):
    """Guards the callbacks of all its subscriptions, services and timers, those that rclpy makes for it included.

    A service answers that it failed, if its answer has fields for that.
    """

    _bad: BadMessages | None = None
    _simulated_time: SimulatedTime | None = None

    @property
    def bad_messages(self) -> BadMessages:
        """What was ignored so far."""
        if self._bad is None:
            self._bad = BadMessages(self)
        return self._bad

    def get_clock(self) -> RosClock:
        """See rclpy's Node; simulated time is what was stated last."""
        if self._simulated_time is not None:
            self._simulated_time.take()
        return super().get_clock()

    def create_subscription(self, msg_type: Any, topic: str, callback: Any, *words: Any, **options: Any) -> Any:
        """See rclpy's Node."""
        if isinstance(getattr(callback, "__self__", None), TimeSource):  # rclpy asks, where use_sim_time is set
            options["callback_group"] = UnwaitedGroup()
            subscription = super().create_subscription(msg_type, topic, callback, *words, **options)
            self._simulated_time = SimulatedTime(self, subscription, callback)
            return subscription
        guarded = self._guarded(topic, callback, lambda *_: None)
        return super().create_subscription(msg_type, topic, guarded, *words, **options)

    def create_service(self, srv_type: Any, srv_name: str, callback: Any, *words: Any, **options: Any) -> Any:
        """See rclpy's Node."""
        guarded = self._guarded(srv_name, callback, lambda error, _, response: _failed(response, error))
        return super().create_service(srv_type, srv_name, guarded, *words, **options)

    def create_timer(self, timer_period_sec: float, callback: Any, *words: Any, **options: Any) -> Any:
        """See rclpy's Node."""
        guarded = self._guarded("a timer", callback, lambda *_: None)
        return super().create_timer(timer_period_sec, guarded, *words, **options)

    def _guarded(self, name: str, callback: Callable[..., Any], otherwise: Callable[..., Any]) -> Callable[..., Any]:
        """``callback``, or where it raises what is no business of the caller: ``otherwise`` of the error and its words.

        Args:
            name: of the topic, or service.
            callback: of rclpy's kinds, asynchronous or not.
            otherwise: gives the answer instead.
        """

        @wraps(callback)
        def guarded(*words: Any) -> Any:
            try:
                return callback(*words)
            except Exception as error:  # whatever one message does, the node goes on with the next
                self._unusable(name, error)
                return otherwise(error, *words)

        @wraps(callback)
        async def guarded_later(*words: Any) -> Any:
            try:
                return await callback(*words)
            except Exception as error:  # whatever one message does, the node goes on with the next
                self._unusable(name, error)
                return otherwise(error, *words)

        return guarded_later if iscoroutinefunction(callback) else guarded

    def _unusable(self, name: str, error: Exception) -> None:
        """Log and count an error; raises it again when it comes of the context's end."""
        if isinstance(error, _OVER) or not self.context.ok():
            raise error
        if not isinstance(error, ValueError):  # a fault of ours: the log shows where
            self.get_logger().debug("".join(traceback.format_exception(error)))
        where = traceback.extract_tb(error.__traceback__)[-1]
        kind = "" if isinstance(error, ValueError) else f"{type(error).__name__} in {where.name}, line {where.lineno}: "
        self.bad_messages.add(name, f"{kind}{error}")


def _failed(response: Any, error: Exception) -> Any:
    """An answer that states a failure, where its type can."""
    fields = response.get_fields_and_field_types()
    if fields.get("success") == "boolean":
        response.success = False
    for field in ("message", "reason"):
        if fields.get(field) == "string":
            setattr(response, field, f"this request cannot be used: {error}")
    return response
