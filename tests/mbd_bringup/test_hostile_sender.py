"""Everything that a node listens to is sent what makes no sense, its actions included, and it goes on."""

from __future__ import annotations

import numpy as np
import pytest
import rclpy
from mbd_bringup.ros.hostile.hostile_sender import HostileSender
from mbd_model.ros.guarded_node import GuardedNode
from mbd_msgs.action import MoveGripper
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

pytestmark = pytest.mark.node


@pytest.fixture
def nodes(ros_domain: int):
    """(a node with an action, one that uses it, one that sends, what runs them)."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    server, user = GuardedNode("server", context=context), GuardedNode("user", context=context)
    sender = Node("sender", context=context)
    executor = SingleThreadedExecutor(context=context)
    for node in (server, user, sender):
        executor.add_node(node)
    yield server, user, sender, executor
    executor.shutdown()
    for node in (server, user, sender):
        node.destroy_node()
    rclpy.try_shutdown(context=context)


def test_an_action_and_who_uses_it_live_through_goals_cancels_and_results_that_make_no_sense(nodes):
    server, user, sender, executor = nodes

    def execute(goal):
        goal.succeed()
        return MoveGripper.Result(success=True)

    action = ActionServer(server, MoveGripper, "act", execute)
    client = ActionClient(user, MoveGripper, "act")
    hostile = HostileSender(sender, np.random.default_rng(1))
    asked = {f"/act/_action/{name}" for name in ("send_goal", "cancel_goal", "get_result", "feedback", "status")}
    for _ in range(600):
        hostile.look({"server", "user"})
        if asked <= set(hostile.places) and client.server_is_ready():
            break
        executor.spin_once(timeout_sec=0.05)
    assert asked <= set(hostile.places)
    for _ in hostile.rounds(600):
        for _ in range(2 * len(hostile.places)):
            executor.spin_once(timeout_sec=0.0)
    assert asked <= set(hostile.sent)
    sent = client.send_goal_async(MoveGripper.Goal())
    executor.spin_until_future_complete(sent, timeout_sec=60.0)
    result = sent.result().get_result_async()
    executor.spin_until_future_complete(result, timeout_sec=60.0)
    assert result.result().result.success
    client.destroy()
    action.destroy()
