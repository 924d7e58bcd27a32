"""The camera's side of the perception node: topics in, complete frames out, none queued."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import rclpy
from mbd_model.ros.conversions import clock_seconds, time_from_msg
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from mbd_perception.frames.collect import FrameCollector, PairBuffer, earliest_stamp
from mbd_perception.frames.frame import FrameError, RgbdFrame
from mbd_perception.ros.conversions import frame_from_cloud_msg, frame_from_images

Moment = tuple[Image, Image, CameraInfo] | PointCloud2
# The newest image is the only one of interest: what comes while the node is busy replaces what waits.
NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
IMAGE_TOPICS = {
    "colour": "camera/color/image_raw",
    "depth": "camera/depth/image_raw",
    "camera_info": "camera/color/camera_info",
}
POINTS_TOPIC = "camera/points"


@dataclass
class Counts:
    """Messages received, by kind; ``frames`` are complete ones."""

    colour: int = 0
    depth: int = 0
    camera_info: int = 0
    points: int = 0
    frames: int = 0


def to_frame(moment: Moment) -> RgbdFrame:
    """A frame from its messages; raises FrameError."""
    return frame_from_images(*moment) if isinstance(moment, tuple) else frame_from_cloud_msg(moment)


def camera_frame_id(moment: Moment) -> str:
    """Name of the optical frame a moment was taken in."""
    return moment[1].header.frame_id if isinstance(moment, tuple) else moment.header.frame_id


class CameraIntake:
    """Subscribes to the camera and hands out complete frames.

    Args:
        node: owner of the subscriptions.
        points: True for clouds, False for colour, depth and camera_info.
        tolerance: largest difference of stamps of colour and depth [s].
        on_moment: called with every complete frame (live), before observations get it.

    Attributes:
        counts: what was received.
        newest: stamp of the newest frame [s]; None before the first.
    """

    def __init__(self, node: Node, points: bool, tolerance: float, on_moment: Callable[[Moment], None]) -> None:
        self._node, self._points, self._tolerance, self._on_moment = node, points, tolerance, on_moment
        self.counts = Counts()
        self.newest: float | None = None
        self._pairs: PairBuffer[Image, Image] = PairBuffer(tolerance)
        self._info: CameraInfo | None = None
        self._waiting: list[tuple[FrameCollector[Moment], Future[bool]]] = []
        self._group = ReentrantCallbackGroup()
        # A steady clock for waiting: simulated time may stand still.
        self._steady = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
        if points:
            node.create_subscription(PointCloud2, POINTS_TOPIC, self._on_points, NEWEST)
            return
        node.create_subscription(Image, IMAGE_TOPICS["colour"], self._on_color, NEWEST)
        node.create_subscription(Image, IMAGE_TOPICS["depth"], self._on_depth, NEWEST)
        node.create_subscription(CameraInfo, IMAGE_TOPICS["camera_info"], self._on_info, NEWEST)

    def _on_color(self, msg: Image) -> None:
        """Pair a colour image."""
        self.counts.colour += 1
        self._on_pair(self._pairs.add_color(time_from_msg(msg.header.stamp), msg))

    def _on_depth(self, msg: Image) -> None:
        """Pair a depth image."""
        self.counts.depth += 1
        self._on_pair(self._pairs.add_depth(time_from_msg(msg.header.stamp), msg))

    def _on_info(self, msg: CameraInfo) -> None:
        """Remember the camera's optics."""
        self.counts.camera_info += 1
        self._info = msg

    def _on_points(self, msg: PointCloud2) -> None:
        """A cloud is a frame of its own."""
        self.counts.points += 1
        self._complete(time_from_msg(msg.header.stamp), msg)

    def _on_pair(self, pair: tuple[Image, Image] | None) -> None:
        """A complete frame, once the optics are known."""
        if pair is not None and self._info is not None:
            self._complete(time_from_msg(pair[1].header.stamp), (*pair, self._info))

    def _complete(self, stamp: float, moment: Moment) -> None:
        """Hand a frame to the live view and to the observations that wait for one."""
        self.counts.frames += 1
        self.newest = stamp
        for collector, done in list(self._waiting):
            if collector.offer(stamp, moment) and not done.done():
                done.set_result(True)
        self._on_moment(moment)

    async def next_moments(self, wanted: int, timeout: float) -> list[Moment]:
        """The next frames stamped after now; raises FrameError when they do not come within ``timeout`` [s, wall]."""
        now = clock_seconds(self._node.get_clock())
        collector: FrameCollector[Moment] = FrameCollector(earliest_stamp(now, self.newest), wanted)
        before = Counts(**vars(self.counts))
        done: Future[bool] = Future()

        def give_up() -> None:
            if not done.done():
                done.set_result(False)

        entry = (collector, done)
        self._waiting.append(entry)
        timer = self._node.create_timer(timeout, give_up, self._group, self._steady)
        try:
            complete = await done
        finally:
            self._waiting.remove(entry)
            self._node.destroy_timer(timer)
        if not complete:
            raise FrameError(self._why_none(before, collector, f"within {timeout:g} s"))
        return collector.frames

    def _why_none(self, before: Counts, collector: FrameCollector[Moment], waited: str) -> str:
        """What was missing while an observation waited in vain."""
        came = Counts(**{key: count - getattr(before, key) for key, count in vars(self.counts).items()})
        if self._points and came.points == 0:
            return f"no point cloud arrived {waited} on {POINTS_TOPIC}: start the camera, or set input to 'images'"
        if not self._points:
            missing = [f"{kind} ({topic})" for kind, topic in IMAGE_TOPICS.items() if getattr(came, kind) == 0]
            if missing:
                return f"no {', '.join(missing)} arrived {waited}: start the camera and check the topic names"
            if came.frames == 0:
                return (
                    f"{came.colour} colour and {came.depth} depth images arrived {waited} but no two with the same "
                    f"time stamp (tolerance {self._tolerance:g} s): check the camera's synchronisation"
                )
        return (
            f"{len(collector.frames)} of {collector.wanted} frames arrived {waited}"
            + (f", and {collector.refused} stamped before the request" if collector.refused else "")
            + ": is the camera too slow, or do its clock and use_sim_time differ from this node's?"
        )
