"""A policy of SROS 2 allows what a session's nodes do, and nothing else."""

from __future__ import annotations

from xml.etree import ElementTree

import rclpy
from hypothesis import given
from hypothesis import strategies as st
from mbd_bringup.ros.security_policy import seen_access
from mbd_bringup.security.policy import NodeAccess, access_of, policy_xml
from mbd_msgs.action import MoveTool
from mbd_msgs.msg import Scene
from rclpy.action import ActionClient, ActionServer
from std_srvs.srv import Trigger

names = st.frozensets(st.from_regex(r"(/[a-z][a-z_]*){1,3}", fullmatch=True), max_size=4)
accesses = st.builds(NodeAccess, *[names] * 6)
# Element, attribute and where they stand, as sros2/policy/schemas/policy.xsd has them.
QUALIFIERS = {"topics": {"publish", "subscribe"}, "services": {"reply", "request"}, "actions": {"call", "execute"}}


def read(text: str, path: str) -> dict[str, NodeAccess]:
    """What the profiles of an enclave allow, by node."""
    attributes = {
        "publish": "publishes", "subscribe": "subscribes", "reply": "serves", "request": "asks", "execute": "executes",
        "call": "calls",
    }  # fmt: skip
    found: dict[str, NodeAccess] = {}
    for profile in ElementTree.fromstring(text).iterfind(f"enclaves/enclave[@path='{path}']/profiles/profile"):
        access = NodeAccess()
        for rules in profile:
            ((qualifier, value),) = rules.attrib.items()
            assert qualifier in QUALIFIERS[rules.tag]
            assert value == "ALLOW"
            assert {rule.tag for rule in rules} == {rules.tag.removesuffix("s")}
            access |= NodeAccess(**{attributes[qualifier]: frozenset(str(rule.text) for rule in rules)})
        found[profile.attrib["node"]] = access
    return found


@given(st.dictionaries(st.sampled_from(["recorder", "mapping", "cell"]), accesses, min_size=1))
def test_each_node_may_do_what_it_does_and_all_together_what_each_may(nodes: dict[str, NodeAccess]):
    text = policy_xml(nodes)
    assert read(text, "/mbd") == nodes
    for name, access in nodes.items():
        assert read(text, f"/mbd/{name}") == {name: access}


def test_who_records_may_receive_all_and_publish_no_more():
    access = NodeAccess(publishes=frozenset({"/diagnostics"}), subscribes=frozenset({"/a"}))
    allowed = read(policy_xml({"recorder": access, "mapping": access}, ["recorder"]), "/mbd")
    assert allowed["recorder"].subscribes == {"*"}
    assert allowed["recorder"].publishes == {"/diagnostics"}
    assert allowed["mapping"] == access


def test_an_action_is_one_and_not_its_topics_and_services():
    server = ["/arm/move/_action/send_goal", "/arm/move/_action/cancel_goal", "/arm/stop"]
    access = access_of(["/arm/move/_action/status"], ["/clock"], server, ["/other/_action/get_result"])
    assert access == NodeAccess(
        subscribes=frozenset({"/clock"}),
        serves=frozenset({"/arm/stop"}),
        executes=frozenset({"/arm/move"}),
        calls=frozenset({"/other"}),
    )


def test_what_a_node_does_is_seen_in_the_graph(ros_domain: int):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("talks", context=context)
    try:
        node.create_publisher(Scene, "perception/source_scene", 1)
        node.create_subscription(Scene, "perception/target_scene", lambda _: None, 1)
        node.create_service(Trigger, "talks/stop", lambda _, response: response)
        node.create_client(Trigger, "other/stop")
        ActionServer(node, MoveTool, "arm/move", lambda _: MoveTool.Result())
        ActionClient(node, MoveTool, "arm/other")
        access = seen_access(node, {"talks", "absent"})["talks"]
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)
    assert "/perception/source_scene" in access.publishes
    assert "/perception/target_scene" in access.subscribes
    assert {"/talks/stop", "/talks/set_parameters"} <= access.serves
    assert access.asks == {"/other/stop"}
    assert (access.executes, access.calls) == ({"/arm/move"}, {"/arm/other"})
