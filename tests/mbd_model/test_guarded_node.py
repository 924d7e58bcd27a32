"""Nothing that is sent ends a node: it is logged once, counted on diagnostics, and the node goes on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from mbd_model.errors import MbdError
from mbd_model.ros.guarded_node import GuardedNode
from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.qos import EVENTS
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger


class Fragile(GuardedNode):
    """Takes nothing but numbers."""

    def __init__(self, **options: object) -> None:
        super().__init__("fragile", **options)
        self.taken: list[int] = []
        self.times: list[dict[str, int]] = []
        self.create_subscription(String, "number", lambda msg: self.taken.append(int(msg.data)), EVENTS)
        self.create_subscription(String, "timed", self._on_timed, EVENTS, raw=True)
        self.create_service(SetBool, "set", self._on_set)
        self.create_service(Trigger, "later", self._on_later)
        self.create_timer(0.05, self._tick)
        self.ticks = 0

    def _on_timed(self, data: bytes, info: dict[str, int]) -> None:
        self.times.append(info)
        raise KeyError(len(data))

    def _on_set(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if request.data:
            raise MbdError("not so")
        response.success = True
        return response

    async def _on_later(self, _: Trigger.Request, __: Trigger.Response) -> Trigger.Response:
        raise ZeroDivisionError

    def _tick(self) -> None:
        self.ticks += 1
        raise AttributeError("none of that")


class Bench:
    """A fragile node and who talks to it."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.fragile = Fragile(context=self.context)
        self.other = Node("other", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.fragile)
        self.executor.add_node(self.other)

    def until(self, happened: Callable[[], bool], what: str) -> None:
        deadline = time.monotonic() + 30.0
        while not happened():
            assert time.monotonic() < deadline, f"waited for {what}"
            self.executor.spin_once(timeout_sec=0.1)

    def answer(self, kind: type, name: str, request: object) -> object:
        client = self.other.create_client(kind, name)
        self.until(client.service_is_ready, name)
        asked = client.call_async(request)
        self.until(asked.done, f"an answer of {name}")
        return asked.result()


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    made = Bench(ros_domain)
    yield made
    made.executor.shutdown()
    rclpy.try_shutdown(context=made.context)


def test_what_a_callback_cannot_take_is_counted_on_diagnostics_and_the_next_is_taken(bench: Bench):
    reports: list[DiagnosticArray] = []
    bench.other.create_subscription(DiagnosticArray, "diagnostics", reports.append, EVENTS)
    number, timed = (bench.other.create_publisher(String, t, EVENTS) for t in ("number", "timed"))
    bench.until(lambda: number.get_subscription_count() and timed.get_subscription_count(), "subscriptions")
    for text in ("1", "one", "", "2"):
        number.publish(String(data=text))
    timed.publish(String(data="x"))
    bench.until(lambda: bench.fragile.taken == [1, 2] and len(bench.fragile.times) == 1, "both numbers")
    assert "received_timestamp" in bench.fragile.times[0]
    bench.until(lambda: bench.fragile.ticks > 3, "the timer to go on")

    def counted() -> bool:
        values = {v.key: int(v.value) for r in reports for s in r.status for v in s.values}
        return (values.get("number"), values.get("timed")) == (2, 1) and values.get("a timer", 0) > 1

    bench.until(counted, "counts on diagnostics")


def test_a_service_that_cannot_take_a_request_answers_that_it_failed(bench: Bench):
    refused = bench.answer(SetBool, "set", SetBool.Request(data=True))
    assert (refused.success, refused.message) == (False, "this request cannot be used: not so")
    assert bench.answer(SetBool, "set", SetBool.Request(data=False)).success
    assert not bench.answer(Trigger, "later", Trigger.Request()).success


@pytest.mark.parametrize("damage", ["folder", "bytes", "nothing"])
def test_a_kept_file_that_is_none_is_set_aside_and_never_over_another(damage: str, ros_domain: int, tmp_path: Path):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    file = tmp_path / "fact.cdr"
    (tmp_path / "fact.broken").mkdir()
    if damage == "folder":
        file.mkdir()
    else:
        file.write_bytes(b"\xff" * 7 if damage == "bytes" else b"")
    latched = LatchedPublisher(Node("keeper", context=context), String, "fact", str(tmp_path))
    assert latched.last is None
    assert sorted(p.name for p in tmp_path.iterdir()) == ["fact.broken", "fact.broken1"]
    latched.publish(String(data="new"))
    assert file.is_file()
    rclpy.try_shutdown(context=context)


def test_a_state_folder_that_cannot_be_is_one_sentence(ros_domain: int, tmp_path: Path):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    (tmp_path / "file").touch()
    with pytest.raises(MbdError, match=r"state_dir .* cannot be used"):
        LatchedPublisher(Node("keeper", context=context), String, "fact", str(tmp_path / "file" / "state"))
    rclpy.try_shutdown(context=context)
