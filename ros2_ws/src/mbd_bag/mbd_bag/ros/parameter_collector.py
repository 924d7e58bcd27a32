"""Ask every node of the graph once for its parameters."""

from __future__ import annotations

import array
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbd_model.ros.patient_call import call_within
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

from mbd_bag.session.session_facts import parameter_facts

if TYPE_CHECKING:
    NamesClient = Client[ListParameters.Request, ListParameters.Response]
    ValuesClient = Client[GetParameters.Request, GetParameters.Response]

_PATIENCE = 5.0  # [s] for an answer
_ATTEMPTS = 3  # an answer can be lost: a server may be found before it has found who asks


class ParameterCollector:
    """Looks once a second for nodes not asked yet, as soon as their services are there.

    Args:
        node: on whose behalf; it is not asked.
        take: takes the facts of one node.
    """

    def __init__(self, node: Node, take: Callable[[dict[str, str]], None]) -> None:
        self._node = node
        self._take = take
        self._attempts: dict[str, int] = {}
        self._waiting: dict[str, tuple[NamesClient, ValuesClient]] = {}
        self._used_clients: list[NamesClient | ValuesClient] = []
        node.create_timer(1.0, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _look(self) -> None:
        for client in self._used_clients:
            self._node.destroy_client(client)
        self._used_clients.clear()
        for name, namespace in self._node.get_node_names_and_namespaces():
            full = f"{namespace.rstrip('/')}/{name}"
            if full in self._attempts or name.startswith("_") or full == self._node.get_fully_qualified_name():
                continue
            self._attempts[full] = 0
            self._wait_for(full)
        for full, (names, values) in list(self._waiting.items()):
            if names.service_is_ready() and values.service_is_ready():
                del self._waiting[full]
                self._ask(full, names, values)

    def _wait_for(self, full: str) -> None:
        """Have a node asked as soon as its services are there."""
        names = self._node.create_client(ListParameters, f"{full}/list_parameters")
        self._waiting[full] = (names, self._node.create_client(GetParameters, f"{full}/get_parameters"))

    def _ask(self, full: str, names: NamesClient, values: ValuesClient) -> None:
        self._attempts[full] += 1

        def on_names(listed: ListParameters.Response | None) -> None:
            if listed is None:
                on_values([], None)
                return
            wanted = list(listed.result.names)
            request = GetParameters.Request(names=wanted)
            call_within(self._node, values, request, _PATIENCE, lambda got: on_values(wanted, got))

        def on_values(wanted: list[str], got: GetParameters.Response | None) -> None:
            self._used_clients += [names, values]
            if got is None:
                self._no_answer(full)
                return
            read = (host_free(parameter_value_to_python(v)) for v in got.values)
            self._take(parameter_facts(full, dict(zip(wanted, read, strict=False))))

        call_within(self._node, names, ListParameters.Request(), _PATIENCE, on_names)

    def _no_answer(self, full: str) -> None:
        if self._attempts[full] < _ATTEMPTS:
            self._wait_for(full)
            return
        self._node.get_logger().warning(
            f"{full} did not report its parameters, {_ATTEMPTS} times asked: the bag lacks them"
        )


def host_free(value: Any) -> Any:
    """A parameter's value without the folders of this machine, of which a bag states nothing."""
    if isinstance(value, str) and value.startswith("/") and Path(value).exists():
        return Path(value).name
    return list(value) if isinstance(value, array.array) else value
