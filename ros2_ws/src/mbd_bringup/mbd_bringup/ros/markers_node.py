"""Node ``markers``: the session as markers for RViz and Foxglove."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

from geometry_msgs.msg import Point, Vector3
from mbd_model.ros import conversions
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import LATCHED
from mbd_model.ros.run_node import run_node
from mbd_msgs import msg as m
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from mbd_bringup.parameters import MARKERS
from mbd_bringup.session_shapes import LETTER, STEP_LETTER, DrawnShape, Form, SessionFacts, session_shapes

Message = TypeVar("Message")

MARKER_TYPE = {
    Form.BOX: Marker.CUBE,
    Form.TEXT: Marker.TEXT_VIEW_FACING,
    Form.ARROW: Marker.ARROW,
    Form.PATH: Marker.LINE_STRIP,
}


class MarkersNode(TableNode):
    """Publishes session/markers again with each fact it receives: a pure function of latched inputs, itself latched."""

    def __init__(self, **options: Any) -> None:
        super().__init__(MARKERS, **options)
        self._aside = self.values["source_aside"]
        self._frame = ""
        self._facts = SessionFacts({})
        self._out = self.create_publisher(MarkerArray, "session/markers", LATCHED)
        self._listen(m.SessionState, "interaction/state", self._state)
        self._listen(m.Scene, "perception/source_scene", self._scene)
        self._listen(m.Scene, "perception/target_scene", self._scene)
        self._listen(m.Task, "demonstration/task", self._task)
        self._listen(m.MappingEstimate, "mapping/estimate", self._estimate)

    def _listen(self, kind: type[Message], topic: str, change: Callable[[Message], SessionFacts]) -> None:
        def on_message(msg: Message) -> None:
            try:
                facts = change(msg)
            except ValueError as error:  # MbdError is one
                self.get_logger().error(f"{topic} is unusable and not drawn: {error}")
                return
            if facts != self._facts:
                self._facts = facts
                self._out.publish(self._markers())

        self.create_subscription(kind, topic, on_message, LATCHED)

    def _state(self, msg: m.SessionState) -> SessionFacts:
        return replace(self._facts, assists=conversions.state_from_msg(msg).assists)

    def _scene(self, msg: m.Scene) -> SessionFacts:
        scene = conversions.scene_from_msg(msg)
        self._frame = scene.frame_id
        return replace(self._facts, scenes={**self._facts.scenes, scene.role: scene})

    def _task(self, msg: m.Task) -> SessionFacts:
        self._frame = self._frame or msg.source.header.frame_id
        return replace(self._facts, task=conversions.task_from_msg(msg))

    def _estimate(self, msg: m.MappingEstimate) -> SessionFacts:
        return replace(self._facts, estimate=conversions.estimate_from_msg(msg))

    def _markers(self) -> MarkerArray:
        """Every shape as a marker, after one that removes what was shown before."""
        frame = conversions.header(0.0, self._frame)  # stamp 0: whatever the transforms are now
        markers = [Marker(header=frame, action=Marker.DELETEALL)]
        for number, shape in enumerate(session_shapes(self._facts, self._aside)):
            markers.append(_marker(shape, number))
            markers[-1].header = frame
        return MarkerArray(markers=markers)


def _marker(shape: DrawnShape, number: int) -> Marker:
    red, green, blue, opacity = shape.color
    marker = Marker(
        ns=shape.group,
        id=number,
        type=MARKER_TYPE[shape.form],
        color=ColorRGBA(r=red, g=green, b=blue, a=opacity),
        text=shape.text,
    )
    points = [Point(x=x, y=y, z=z) for x, y, z in shape.points]
    marker.pose.orientation.w = 1.0
    if shape.form in (Form.ARROW, Form.PATH):
        marker.points = points
        # Of an arrow: diameters of shaft and head, length of the head; of a path: its width.
        arrow = shape.form is Form.ARROW
        marker.scale = Vector3(x=0.01, y=0.025, z=0.04) if arrow else Vector3(x=0.004, y=0.0, z=0.0)
        return marker
    marker.pose.position = points[0]
    if shape.form is Form.TEXT:
        marker.scale = Vector3(x=0.0, y=0.0, z=STEP_LETTER if shape.group == "steps" else LETTER)
        return marker
    width, depth, height = shape.size
    marker.scale = Vector3(x=depth, y=width, z=height)
    marker.pose.orientation.z, marker.pose.orientation.w = math.sin(shape.yaw / 2), math.cos(shape.yaw / 2)
    return marker


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("markers", MarkersNode)


if __name__ == "__main__":
    main()
