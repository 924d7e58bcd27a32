"""What nobody can use ends neither the demonstration node nor the execution node.

The messages are those of ../shared/cases/nodes/node_dies_unknown_enum.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from mbd_demonstration.ros.node import DemonstrationNode
from mbd_execution.ros.node import ExecutionNode
from mbd_interaction.synthetic import row_of_objects
from mbd_model.objects import Role
from mbd_model.ros.conversions import scene_to_msg
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_msgs import msg as m
from rclpy.executors import SingleThreadedExecutor

UNKNOWN_RELATION = m.Scene(
    role=1, objects=[m.ObjectFeatures(object_id="s1", relations=[m.SpatialRelation(kind=99, other_id="x")])]
)
UNKNOWN_PHASE = m.SessionState(phase=99)


@dataclass
class Bench:
    """A node, and in the same process those who send to it."""

    executor: SingleThreadedExecutor
    peer: rclpy.node.Node
    node: TableNode
    reports: list[DiagnosticArray] = field(default_factory=list)

    def until(self, done: Callable[[], bool]) -> None:
        end = time.monotonic() + 30.0
        while not done():
            assert time.monotonic() < end, "waited in vain"
            self.executor.spin_once(timeout_sec=0.02)

    def counted(self, topic: str) -> int:
        """How many bad messages of a topic the node's last report counts."""
        values = [v for r in self.reports for s in r.status for v in s.values if v.key == topic]
        return int(values[-1].value) if values else 0


@pytest.fixture(params=[DemonstrationNode, ExecutionNode])
def bench(request: pytest.FixtureRequest, ros_domain: int) -> Iterator[Bench]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    made = Bench(
        SingleThreadedExecutor(context=context),
        rclpy.create_node("peer", context=context),
        request.param(context=context),
    )
    made.peer.create_subscription(DiagnosticArray, "diagnostics", made.reports.append, EVENTS)
    for node in (made.peer, made.node):
        made.executor.add_node(node)
    yield made
    made.executor.shutdown()
    made.node.destroy_node()
    made.peer.destroy_node()
    rclpy.try_shutdown(context=context)


def test_an_unknown_value_in_a_latched_message_is_counted_and_ignored_and_the_next_one_taken(bench: Bench):
    """Both came latched, so that each restart got them again."""
    role, topic = (
        (Role.SOURCE, "perception/source_scene")
        if isinstance(bench.node, DemonstrationNode)
        else (Role.TARGET, "perception/target_scene")
    )
    scenes = bench.peer.create_publisher(m.Scene, topic, LATCHED)
    states = bench.peer.create_publisher(m.SessionState, "interaction/state", LATCHED)
    scenes.publish(UNKNOWN_RELATION)
    states.publish(UNKNOWN_PHASE)
    bench.until(lambda: bench.counted(topic) == 1 and bench.counted("interaction/state") == 1)
    scenes.publish(scene_to_msg(row_of_objects(role, "s", 2)))
    states.publish(m.SessionState(phase=m.SessionState.EXECUTE))
    if isinstance(bench.node, DemonstrationNode):
        bench.until(lambda: bench.node.scene is not None)
    scenes.publish(UNKNOWN_RELATION)
    bench.until(lambda: bench.counted(topic) == 2)
    assert bench.counted("interaction/state") == 1
    if isinstance(bench.node, DemonstrationNode):
        assert bench.node.scene is not None and bench.node.scene.ids == ("s1", "s2")
