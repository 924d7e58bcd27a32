"""RViz and Foxglove are shown the objects, the steps and the mapping as they are."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
import yaml
from mbd_bringup.ros.markers_node import MarkersNode
from mbd_bringup.session_shapes import ASSISTED, INFERRED, DrawnShape, Form, SessionFacts, session_shapes
from mbd_interaction.synthetic import row_of_objects, stacking_task
from mbd_model.assists import Assist
from mbd_model.estimate import Mapping, MappingEstimate
from mbd_model.objects import Role
from mbd_model.ros import conversions
from mbd_model.ros.qos import LATCHED
from mbd_model.session import Phase, SessionState
from mbd_msgs import msg as m
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_bringup" / "config"
ASIDE = (0.0, 1.1, 0.0)
SOURCE, TARGET = row_of_objects(Role.SOURCE, "s", 4), row_of_objects(Role.TARGET, "t", 4)
PAIRS = (("s1", "t2"), ("s2", "t1"), ("s3", "t3"), ("s4", "t4"))
KNOWN = SessionFacts(
    {Role.SOURCE: SOURCE, Role.TARGET: TARGET},
    stacking_task(4),
    (Assist("s3", "t3", 2),),
    MappingEstimate("mbd", Mapping(PAIRS), 0.1),
)


def of(shapes: tuple[DrawnShape, ...], form: Form, group: str = "") -> list[DrawnShape]:
    return [s for s in shapes if s.form is form and s.group.startswith(group)]


def test_nothing_known_draws_nothing():
    assert session_shapes(SessionFacts({}), ASIDE) == ()


def test_every_object_is_a_box_of_its_size_with_its_name():
    shapes = session_shapes(KNOWN, ASIDE)
    boxes = of(shapes, Form.BOX, "target")
    assert [(b.points[0], b.size, b.yaw) for b in boxes] == [(o.centroid, o.size, o.yaw) for o in TARGET.objects]
    names = {s.text for s in of(shapes, Form.TEXT, "target")}
    assert names == {f"{t} as {s}" for s, t in PAIRS}


def test_the_source_scene_makes_room_for_the_target_scene():
    alone = session_shapes(SessionFacts({Role.SOURCE: SOURCE}), ASIDE)
    both = session_shapes(KNOWN, ASIDE)
    before = [b.points[0] for b in of(alone, Form.BOX, "source")]
    after = [b.points[0] for b in of(both, Form.BOX, "source")]
    assert before == [o.centroid for o in SOURCE.objects]
    assert after == [tuple(a + b for a, b in zip(p, ASIDE, strict=True)) for p in before]


def test_a_target_scene_older_than_the_source_scene_is_gone():
    newer = dataclasses.replace(SOURCE, stamp=5.0)
    facts = dataclasses.replace(KNOWN, scenes={Role.SOURCE: newer, Role.TARGET: TARGET})
    assert of(session_shapes(facts, ASIDE), Form.BOX, "target") == []


def test_each_pair_is_an_arrow_from_above_the_one_to_above_the_other_and_assisted_ones_look_so():
    arrows = of(session_shapes(KNOWN, ASIDE), Form.ARROW)
    assert len(arrows) == len(PAIRS)
    assert [a.color for a in arrows] == [ASSISTED if s == "s3" else INFERRED for s, _ in PAIRS]
    start, end = arrows[0].points
    assert start == pytest.approx((0.5, 0.2 + 1.1, 0.1))
    assert end == pytest.approx((0.5, 0.4, 0.1))


def test_an_assist_outweighs_an_estimate_that_does_not_know_it_yet():
    facts = dataclasses.replace(KNOWN, assists=(Assist("s1", "t4", 0),))
    assisted = [a for a in of(session_shapes(facts, ASIDE), Form.ARROW) if a.color == ASSISTED]
    assert [a.points[1][1] for a in assisted] == [pytest.approx(0.8)]


def test_the_steps_are_numbered_from_1_along_a_path():
    shapes = session_shapes(KNOWN, ASIDE)
    words = [s.text for s in of(shapes, Form.TEXT, "steps")]
    assert words == ["1 pick", "2 place", "3 pick", "4 place", "5 pick", "6 place"]
    assert len(of(shapes, Form.PATH)[0].points) == 6


@pytest.fixture
def nodes(ros_domain: int) -> Iterator[tuple[Node, list[MarkerArray], SingleThreadedExecutor]]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    executor = SingleThreadedExecutor(context=context)
    speaker, received = Node("speaker", context=context), []
    speaker.create_subscription(MarkerArray, "session/markers", received.append, LATCHED)
    for node in (MarkersNode(context=context), speaker):
        executor.add_node(node)
    yield speaker, received, executor
    executor.shutdown()
    rclpy.shutdown(context=context)


def test_the_node_draws_what_it_receives_and_ignores_what_cannot_be(nodes):
    speaker, received, executor = nodes
    scene = speaker.create_publisher(m.Scene, "perception/target_scene", LATCHED)
    state = speaker.create_publisher(m.SessionState, "interaction/state", LATCHED)
    estimate = speaker.create_publisher(m.MappingEstimate, "mapping/estimate", LATCHED)
    task = speaker.create_publisher(m.Task, "demonstration/task", LATCHED)
    task.publish(conversions.task_to_msg(stacking_task(4)))
    scene.publish(conversions.scene_to_msg(TARGET))
    stamps = (conversions.time_to_msg(1.0),) * 3
    message = conversions.estimate_to_msg(KNOWN.estimate, session="s", threshold=0.02, stamps=stamps)
    estimate.publish(message)
    state.publish(m.SessionState(phase=99))
    state.publish(conversions.state_to_msg(SessionState("s", Phase.ASSIST, assists=KNOWN.assists), 1.0))
    want = len(session_shapes(KNOWN, ASIDE)) + 1
    for _ in range(200):
        executor.spin_once(timeout_sec=0.1)
        if received and len(received[-1].markers) == want and any(k.ns == "mapping" for k in received[-1].markers):
            assisted = [k for k in received[-1].markers if k.ns == "mapping" and k.color.r > 0.9]
            if assisted:
                break
    markers = received[-1].markers
    assert markers[0].action == Marker.DELETEALL
    assert len(markers) == want
    assert len(assisted) == 1
    assert {k.header.frame_id for k in markers} == {"j2n6s300_link_base"}
    # A marker with a zero scale or an all-zero quaternion draws a warning instead of a shape.
    for k in markers[1:]:
        assert max(k.scale.x, k.scale.z) > 0
        assert abs(k.pose.orientation.w) + abs(k.pose.orientation.z) > 0.5


def shown_topics() -> dict[str, set[str]]:
    rviz = yaml.safe_load((CONFIG / "session.rviz").read_text())
    displays = rviz["Visualization Manager"]["Displays"]
    foxglove = json.loads((CONFIG / "foxglove_session.json").read_text())
    words = re.findall(r'"(/[\w/]+)', json.dumps(foxglove["configById"]))
    return {"rviz": {d["Topic"]["Value"] for d in displays if "Topic" in d}, "foxglove": set(words)}


@pytest.mark.parametrize("viewer", ["rviz", "foxglove"])
def test_a_layout_shows_topics_that_there_are(viewer: str):
    page = (CONFIG.parents[3] / "docs" / "topics.md").read_text()
    documented = {f"/{name}" for name in re.findall(r"`([\w/]+)`", page)} | {"/session/markers"}
    topics = shown_topics()[viewer]
    assert "/session/markers" in topics
    assert topics <= documented


def test_the_foxglove_layout_places_every_panel_it_configures():
    layout = json.loads((CONFIG / "foxglove_session.json").read_text())
    placed = set()

    def walk(part: object) -> None:
        if isinstance(part, str):
            placed.add(part)
        else:
            walk(part["first"])
            walk(part["second"])

    walk(layout["layout"])
    assert placed == set(layout["configById"])
