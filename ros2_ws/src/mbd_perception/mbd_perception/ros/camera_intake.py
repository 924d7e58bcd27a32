"""The camera's side of the perception node: topics in, complete frames out, none queued."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import rclpy
from mbd_model.ros.conversions import clock_seconds, time_from_msg
from mbd_model.ros.offered import OfferedSubscription, StreamSource, image_sources
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.serialization import serialize_message
from rclpy.task import Future
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2

from mbd_perception.frames.collect import FrameCollector, PairBuffer, earliest_stamp
from mbd_perception.frames.frame import FrameError, RgbdFrame
from mbd_perception.ros.camera_conversions import frame_from_cloud_msg, frame_from_images, picture_size

Picture = Image | CompressedImage
Moment = tuple[Picture, Picture, CameraInfo] | PointCloud2
IMAGE_TOPICS = {
    "colour": "camera/color/image_raw",
    "depth": "camera/depth/image_raw",
    "camera_info": "camera/color/camera_info",
}
# Names of the same images compressed, by preference.
SUFFIXES = {"colour": ("/compressed",), "depth": ("/compressedDepth", "/compressed")}
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


def serialized(moment: Moment) -> dict[str, bytes]:
    """The messages of a moment as they travelled, by the name of a file each."""
    messages = zip(IMAGE_TOPICS, moment, strict=True) if isinstance(moment, tuple) else [("points", moment)]
    return {f"{name}.cdr": serialize_message(message) for name, message in messages}


def moment_kind(moment: Moment) -> object:
    """What moments of one camera have in common: sizes and encodings of their images, their optics."""
    if not isinstance(moment, tuple):
        return moment.width, moment.height
    *images, info = moment
    layouts = [(m.width, m.height, m.encoding) if isinstance(m, Image) else m.format for m in images]
    return (*layouts, *optics_of(info))


def optics_of(info: CameraInfo) -> tuple[object, ...]:
    """What a camera_info states of the pictures, to compare."""
    region = info.roi
    corner = region.x_offset, region.y_offset, region.width, region.height
    return info.width, info.height, tuple(info.k), info.binning_x, info.binning_y, corner


class CameraIntake:
    """Subscribes to the camera and hands out complete frames.

    The newest image is the only one of interest: what comes while the node is busy replaces what waits. How reliably
    they are asked for, and compressed or not, is what their publishers offer.

    Args:
        node: owner of the subscriptions.
        points: True for clouds, False for colour, depth and camera_info.
        transport: of images: "raw", "compressed" or "auto", as ``image_sources`` takes it.
        tolerance: largest difference of stamps of colour and depth [s].
        on_moment: called with every complete frame (live), before observations get it.

    Attributes:
        counts: what was received.
        newest: stamp of the newest frame [s]; None before the first.
    """

    def __init__(
        self, node: Node, points: bool, transport: str, tolerance: float, on_moment: Callable[[Moment], None]
    ) -> None:
        self._node, self._points, self._tolerance, self._on_moment = node, points, tolerance, on_moment
        self.counts = Counts()
        self.newest: float | None = None
        self._pairs: PairBuffer[Picture, Picture] = PairBuffer(tolerance)
        self._info: CameraInfo | None = None
        # A pair of another size than the last camera_info: when the camera changes, that may come after.
        self._odd: tuple[Picture, Picture] | None = None
        self._waiting: list[tuple[FrameCollector[Moment], Future[bool]]] = []
        self._group = ReentrantCallbackGroup()
        # A steady clock for waiting: simulated time may stand still.
        self._steady = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
        self._streams: dict[str, OfferedSubscription] = {}
        if points:
            self._streams["points"] = OfferedSubscription(
                node, [StreamSource(PointCloud2, POINTS_TOPIC)], self._on_points
            )
            return
        info = [StreamSource(CameraInfo, IMAGE_TOPICS["camera_info"])]
        self._streams["camera_info"] = OfferedSubscription(node, info, self._on_info)
        for kind, on_image in (("colour", self._on_color), ("depth", self._on_depth)):
            sources = image_sources(
                node, IMAGE_TOPICS[kind], Image, CompressedImage, suffixes=SUFFIXES[kind], transport=transport
            )
            self._streams[kind] = OfferedSubscription(node, sources, on_image)

    @property
    def asked(self) -> str:
        """By which topics the streams come and how reliably they are asked for, for people."""
        return ", ".join(
            f"{stream.source.topic} {'reliable' if stream.reliable else 'best effort'}"
            for stream in self._streams.values()
        )

    def _on_color(self, msg: Picture) -> None:
        """Pair a colour image."""
        self.counts.colour += 1
        self._on_pair(self._pairs.add_color(time_from_msg(msg.header.stamp), msg))

    def _on_depth(self, msg: Picture) -> None:
        """Pair a depth image."""
        self.counts.depth += 1
        self._on_pair(self._pairs.add_depth(time_from_msg(msg.header.stamp), msg))

    def _on_info(self, msg: CameraInfo) -> None:
        """Remember the camera's optics."""
        self.counts.camera_info += 1
        self._info = msg
        self._complete_odd()

    def _on_points(self, msg: PointCloud2) -> None:
        """A cloud is a frame of its own."""
        self.counts.points += 1
        self._complete(time_from_msg(msg.header.stamp), msg)

    def _on_pair(self, pair: tuple[Picture, Picture] | None) -> None:
        """A complete frame, once its optics are known."""
        if pair is None or self._info is None:
            return
        self._complete_odd()
        depth = pair[1]
        size = sorted(picture_size(self._info))
        if isinstance(depth, Image) and sorted((depth.width, depth.height)) != size:
            self._odd = pair
            return
        self._complete(time_from_msg(depth.header.stamp), (*pair, self._info))

    def _complete_odd(self) -> None:
        """The pair that waited for its camera_info, with what came instead when that is no better: it is answered."""
        if self._odd is not None and self._info is not None:
            pair, self._odd = self._odd, None
            self._complete(time_from_msg(pair[1].header.stamp), (*pair, self._info))

    def _complete(self, stamp: float, moment: Moment) -> None:
        """Hand a frame to the live view and to the observations that wait for one."""
        self.counts.frames += 1
        self.newest = stamp
        kind = moment_kind(moment)
        for collector, done in list(self._waiting):
            if collector.offer(stamp, moment, kind) and not done.done():
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
            missing = [
                f"{kind} ({self._streams[kind].source.topic})" for kind in IMAGE_TOPICS if getattr(came, kind) == 0
            ]
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
