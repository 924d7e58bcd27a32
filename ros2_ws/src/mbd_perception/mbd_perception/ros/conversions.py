"""From scenes to visualization and diagnostic messages."""

from __future__ import annotations

import array
import colorsys

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Vector3
from mbd_model.objects import Scene
from mbd_model.ros.conversions import header
from numpy.typing import NDArray
from sensor_msgs.msg import Image
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray


def scene_markers(scene: Scene, table: tuple[float, float, float, float]) -> MarkerArray:
    """A box in the object's colour and a label above it for every object; replaces what was shown before.

    ``table`` is (a, b, c, d) of the plane they stand on [m, frame of the scene].
    """
    a, b, c, d = table
    markers = [Marker(header=header(scene.stamp, scene.frame_id), action=Marker.DELETEALL)]
    for number, obj in enumerate(scene.objects):
        width, depth, height = obj.size
        x, y, _ = obj.box_center or obj.centroid
        foot = -(a * x + b * y + d) / c
        hue = 0.0 if obj.hue is None else obj.hue / 360.0
        red, green, blue = colorsys.hsv_to_rgb(hue, 0.0 if obj.hue is None else 0.9, 0.9)
        box = Marker(
            header=header(scene.stamp, scene.frame_id),
            ns=f"{scene.role}_boxes",
            id=number,
            type=Marker.CUBE,
            scale=Vector3(x=depth, y=width, z=height),
            color=ColorRGBA(r=red, g=green, b=blue, a=0.5),
        )
        box.pose.position = Point(x=x, y=y, z=foot + height / 2)
        box.pose.orientation.z = float(np.sin(obj.yaw / 2))
        box.pose.orientation.w = float(np.cos(obj.yaw / 2))
        label = Marker(
            header=header(scene.stamp, scene.frame_id),
            ns=f"{scene.role}_labels",
            id=number,
            type=Marker.TEXT_VIEW_FACING,
            scale=Vector3(x=0.0, y=0.0, z=0.03),
            color=ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0),
            text=f"{obj.object_id} {obj.color_name} {obj.object_class}",
        )
        label.pose.position = Point(x=x, y=y, z=foot + height + 0.04)
        markers += [box, label]
    return MarkerArray(markers=markers)


def color_to_msg(picture: NDArray[np.uint8], stamp: float, frame_id: str) -> Image:
    """(height, width, 3) uint8 RGB as an rgb8 image."""
    height, width = picture.shape[:2]
    data = array.array("B")
    data.frombytes(np.ascontiguousarray(picture).data.cast("B"))
    return Image(header=header(stamp, frame_id), height=height, width=width, encoding="rgb8", step=3 * width, data=data)


def status(name: str, problem: str, values: dict[str, str]) -> DiagnosticStatus:
    """One diagnostic status: OK when ``problem`` is empty, else a warning that states it."""
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN if problem else DiagnosticStatus.OK,
        name=name,
        message=problem or "working",
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
