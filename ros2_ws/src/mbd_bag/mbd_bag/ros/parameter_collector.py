"""Ask every node of the graph once for its parameters."""

from __future__ import annotations

import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

from mbd_bag.session.session_facts import parameter_facts


class ParameterCollector:
    """Looks once a second for nodes not asked yet, as soon as their services are there.

    Args:
        node: on whose behalf; it is not asked.
        take: takes the facts of one node.
    """

    def __init__(self, node: Node, take: Callable[[dict[str, str]], None]) -> None:
        self._node = node
        self._take = take
        self._asked: set[str] = set()
        self._waiting: dict[str, tuple[Any, Any]] = {}
        self._done_clients: list[Any] = []
        node.create_timer(1.0, self._look, clock=rclpy.clock.Clock())

    def _look(self) -> None:
        for client in self._done_clients:
            self._node.destroy_client(client)
        self._done_clients.clear()
        for name, namespace in self._node.get_node_names_and_namespaces():
            full = f"{namespace.rstrip('/')}/{name}"
            if full in self._asked or name.startswith("_") or full == self._node.get_fully_qualified_name():
                continue
            self._asked.add(full)
            names = self._node.create_client(ListParameters, f"{full}/list_parameters")
            self._waiting[full] = (names, self._node.create_client(GetParameters, f"{full}/get_parameters"))
        for full, (names, values) in list(self._waiting.items()):
            if names.service_is_ready() and values.service_is_ready():
                del self._waiting[full]
                self._ask(full, names, values)

    def _ask(self, full: str, names: Any, values: Any) -> None:
        def on_names(future: Any) -> None:
            self._done_clients.append(names)
            request = GetParameters.Request(names=[] if future.result() is None else future.result().result.names)
            values.call_async(request).add_done_callback(lambda answer: on_values(request.names, answer))

        def on_values(asked: list[str], future: Any) -> None:
            self._done_clients.append(values)
            got = [] if future.result() is None else map(parameter_value_to_python, future.result().values)
            self._take(parameter_facts(full, dict(zip(asked, (host_free(v) for v in got), strict=False))))

        names.call_async(ListParameters.Request()).add_done_callback(on_names)


def host_free(value: Any) -> Any:
    """A parameter's value without the folders of this machine, of which a bag says nothing."""
    if isinstance(value, str) and value.startswith("/") and Path(value).exists():
        return Path(value).name
    return list(value) if isinstance(value, array.array) else value
