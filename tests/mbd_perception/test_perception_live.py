"""What the perception node shows and publishes while it watches."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from mbd_model.ros.conversions import stamp_from_msg
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs.msg import Scene
from mbd_msgs.srv import Observe
from perception_rig import FRAME, Rig, good_images
from sensor_msgs.msg import Image
from visualization_msgs.msg import Marker, MarkerArray


def test_live(rig: Callable[..., Rig]) -> None:
    """Whoever listens gets objects live, under the ids of the last observation, and a picture of them."""
    table = rig(good_images)
    observed = table.observe(Observe.Request.TARGET)
    scenes: list[Scene] = []
    pictures: list[Image] = []
    table.camera.create_subscription(Scene, "perception/live_scene", scenes.append, SENSOR)
    table.camera.create_subscription(Image, "perception/live_image", pictures.append, SENSOR)
    while len(scenes) < 3 or not pictures:
        table.executor.spin_once(timeout_sec=5.0)
    assert {o.id for o in scenes[-1].objects} == {o.id for o in observed.scene.objects}
    assert (pictures[0].width, pictures[0].height, pictures[0].encoding) == (320, 240, "rgb8")


def test_shown(rig: Callable[..., Rig]) -> None:
    """An observation is shown by markers and an annotated picture; diagnostics show rate, latency, table, objects."""
    table = rig(good_images)
    markers: list[MarkerArray] = []
    pictures: list[Image] = []
    reports: list[DiagnosticArray] = []
    answer = table.observe()
    table.camera.create_subscription(MarkerArray, "perception/markers", markers.append, LATCHED)
    table.camera.create_subscription(Image, "perception/image", pictures.append, LATCHED)
    table.camera.create_subscription(DiagnosticArray, "diagnostics", reports.append, EVENTS)
    while not (markers and pictures and len(reports) > 1):
        table.executor.spin_once(timeout_sec=5.0)
    shown = [m for m in markers[0].markers if m.action == Marker.ADD]
    assert {m.text.split()[0] for m in shown if m.type == Marker.TEXT_VIEW_FACING} == {"s1", "s2"}
    for box, obj in zip([m for m in shown if m.type == Marker.CUBE], answer.scene.objects, strict=True):
        assert (box.pose.position.x, box.pose.position.y) == pytest.approx(
            (obj.box_center.x, obj.box_center.y), abs=0.02
        )
    assert (pictures[0].width, pictures[0].height) == (320, 240)
    picture = np.frombuffer(pictures[0].data, np.uint8).reshape(240, 320, 3)
    assert (picture != FRAME.color).any()
    values = {v.key: v.value for v in reports[-1].status[0].values}
    assert values["table found"] == "True"
    assert values["objects"] == "2"
    assert float(values["frame rate [Hz]"]) > 0
    assert float(values["latency of the last observation [ms]"]) > 0
    assert reports[-1].status[0].level == DiagnosticStatus.OK


def test_drops_frames(rig: Callable[..., Rig]) -> None:
    """Frames that come while it is busy are dropped: what it shows next is of now, however many came meanwhile."""
    table = rig(good_images)
    scenes: list[Scene] = []
    table.camera.create_subscription(Scene, "perception/live_scene", scenes.append, SENSOR)
    while not scenes:
        table.executor.spin_once(timeout_sec=5.0)
    for _ in range(60):  # perception is not served meanwhile
        table.camera.shoot()
    last = table.camera.get_clock().now().nanoseconds
    scenes.clear()
    old = 0
    while not scenes or stamp_of(scenes[-1]) < last:
        table.executor.spin_once(timeout_sec=5.0)
        old = sum(stamp_of(s) < last for s in scenes)
    assert old <= 12


def stamp_of(scene: Scene) -> int:
    """Stamp of a scene [ns]."""
    return stamp_from_msg(scene.header.stamp)
