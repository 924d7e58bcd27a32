"""Keep what a session says beside its bag, so that a recorder that comes back has what it missed.

Run: ``./mbd run mbd_bag spool --ros-args -p folder:=sessions/p07/spool``
"""

from __future__ import annotations

import re
import time
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from mbd_model.parameters import ParameterTable
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.run_node import run_node
from rclpy.clock import Clock, ClockType
from rclpy.subscription import Subscription

from mbd_bag.errors import BagError
from mbd_bag.ros.qos_profiles import asked_profile, topic_qos
from mbd_bag.ros.raw_subscription import subscribe_raw
from mbd_bag.spool.parameters import SECOND_SPOOL, SPOOL, WRITERS, is_spooled
from mbd_bag.spool.spool_file import SpooledMessage, SpoolWriter, spool_path
from mbd_bag.storage.topic_qos import TopicQos, wanted_qos

_DEPTH = 4000  # messages kept for a spool that gets no processor time for a while
_FLUSH, _SYNC = 0.2, 1.0  # [s] between two tries to write what a full disk did not take; between two syncs
_ALL_AGAIN = 10  # looks for new topics from one look at those that are known to the next: their publishers may change


class Spool(TableNode):
    """Subscribes to what is small and sent reliably, and appends the raw bytes to a journal.

    Raises:
        BagError: the journal cannot be written, or a parameter cannot be used.
    """

    def __init__(self, table: ParameterTable = SPOOL, **options: Any) -> None:
        super().__init__(table, **options)
        try:
            self._exclude = [re.compile(pattern) for pattern in self.values["exclude"]]
        except re.error as error:
            raise BagError(f"parameter exclude: {error}") from error
        folder = Path(self.values["folder"]).expanduser().absolute()
        try:
            self._journal = SpoolWriter(
                spool_path(folder, self.values["run"], table.node), int(self.values["limit"] * 1e6)
            )
        except OSError as error:
            raise BagError(
                f"folder {folder} cannot be written ({error.strerror}): give one that this user may write"
            ) from error
        self._sim_time = bool(self.get_parameter("use_sim_time").value)
        self._full = False
        self._looks = 0
        self._settled: set[str] = set()  # topics whose publishers were asked what they offer
        self._taken: dict[str, tuple[TopicQos, Subscription[object]]] = {}
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(self.values["discovery_period"], self._discover, clock=steady)
        self.create_timer(_FLUSH, self._flush, clock=steady)
        self.create_timer(_SYNC, self._sync, clock=steady)
        self._discover()

    def _flush(self) -> None:
        full = not self._journal.flush()
        if full and not self._full:
            self.get_logger().error("the journal cannot be written: make room; what comes is kept in memory until then")
        self._full = full

    def _sync(self) -> None:
        try:
            self._journal.sync()
        except OSError as error:
            self.get_logger().error(f"the journal cannot be written ({error.strerror})", once=True)

    def _discover(self) -> None:
        again = self._looks % _ALL_AGAIN == 0
        self._looks += 1
        for topic, types in self.get_topic_names_and_types():
            if not again and topic in self._settled:
                continue
            if len(types) != 1 or "/msg/" not in types[0] or any(p.fullmatch(topic) for p in self._exclude):
                continue
            offers = tuple(topic_qos(e.qos_profile) for e in self.get_publishers_info_by_topic(topic))
            asked = tuple(
                topic_qos(e.qos_profile)
                for e in self.get_subscriptions_info_by_topic(topic)
                # The recorder's own guess is no publisher's word.
                if e.node_name not in (*WRITERS, "recorder")
            )
            if not offers and not asked:
                continue
            wanted = wanted_qos(offers, asked, _DEPTH)
            taken = self._taken.get(topic)
            if offers:
                self._settled.add(topic)
            if not is_spooled(types[0], wanted):
                continue
            if taken is not None and (taken[0] == wanted or not offers):
                continue
            self._subscribe(topic, types[0], wanted)

    def _subscribe(self, topic: str, msgtype: str, qos: TopicQos) -> None:
        package, kind, name = msgtype.split("/")
        try:
            message_class = getattr(import_module(f"{package}.{kind}"), name)
        except (ImportError, AttributeError):
            return  # the recorder says so
        if topic in self._taken:
            self.destroy_subscription(self._taken[topic][1])

        def keep(data: bytes, info: dict[str, int]) -> None:
            self._journal.append(
                SpooledMessage(
                    topic,
                    msgtype,
                    info.get("source_timestamp") or 0,
                    info.get("publication_sequence_number") or 0,
                    info.get("received_timestamp") or time.time_ns(),
                    self.get_clock().now().nanoseconds if self._sim_time else 0,
                    data,
                )
            )

        self._taken[topic] = (qos, subscribe_raw(self, message_class, topic, keep, asked_profile(qos)))


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node(SPOOL.node, Spool)


def second() -> None:
    """Run its twin, with a journal of its own."""
    run_node(SECOND_SPOOL.node, partial(Spool, SECOND_SPOOL))


if __name__ == "__main__":
    main()
