"""Node ``perception``: camera in, scenes out."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import cv2
import rclpy
from ament_index_python.packages import get_package_share_directory
from diagnostic_msgs.msg import DiagnosticArray
from mbd_model.conversions import role_from_code, scene_to_msg, time_from_msg
from mbd_model.errors import MbdError
from mbd_model.latch import LatchedPublisher
from mbd_model.objects import Role
from mbd_model.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs.msg import Scene
from mbd_msgs.srv import Observe
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from visualization_msgs.msg import MarkerArray

from mbd_perception.collect import FrameCollector, PairBuffer, earliest_stamp
from mbd_perception.components import JumpConfig
from mbd_perception.conversions import frame_from_cloud_msg, frame_from_images, scene_markers, status
from mbd_perception.frame import FrameError, RgbdFrame, fuse
from mbd_perception.knowledge import load_knowledge
from mbd_perception.measure import Observation, ObserveConfig, observe
from mbd_perception.parameters import PARAMETERS, ParameterSpec
from mbd_perception.plane import PlaneConfig
from mbd_perception.pose import CameraPose, pose_from_quaternion
from mbd_perception.segmentation import SegmentationConfig, Workspace

Moment = tuple[Image, Image, CameraInfo] | PointCloud2


class PerceptionNode(Node):
    """Subscribes to the camera, answers ``perception/observe`` and latches the scenes it saw.

    One thread serves everything: the service handler is a coroutine that waits for its frames without blocking their
    subscriptions.
    """

    def __init__(self, **options: Any) -> None:
        """``options`` go to rclpy's Node (parameter_overrides, namespace…)."""
        super().__init__("perception", **options)
        for spec in PARAMETERS:
            self.declare_parameter(spec.name, spec.default, _descriptor(spec))
        for spec in PARAMETERS:
            if spec.choices and self._get(spec.name) not in spec.choices:
                raise MbdError(f"parameter {spec.name} is '{self._get(spec.name)}', expected one of {spec.choices}")
        self._config = self._read_config()
        self._pose = self._read_pose()
        self._pairs: PairBuffer[Image, Image] = PairBuffer(self._get("sync_tolerance"))
        self._camera_info: CameraInfo | None = None
        self._waiting: list[tuple[FrameCollector[Moment], Future]] = []
        self._newest: float | None = None
        self._received = {"colour": 0, "depth": 0, "camera_info": 0, "points": 0, "frames": 0}
        self._frames_reported, self._reported_at = 0, time.monotonic()
        self._last: Observation | None = None
        self._problem = ""
        self._latency = 0.0
        state_dir = self._get("state_dir")
        self._scenes = {role: LatchedPublisher(self, Scene, f"perception/{role}_scene", state_dir) for role in Role}
        self._markers = self.create_publisher(MarkerArray, "perception/markers", LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, "diagnostics", EVENTS)
        if self._get("input") == "images":
            self.create_subscription(Image, "camera/color/image_raw", self._on_color, SENSOR)
            self.create_subscription(Image, "camera/depth/image_raw", self._on_depth, SENSOR)
            self.create_subscription(CameraInfo, "camera/color/camera_info", self._on_info, SENSOR)
        else:
            self.create_subscription(PointCloud2, "camera/points", self._on_points, SENSOR)
        # A waiting handler holds its callback group: in the node's own it would shut out the frames it waits for.
        self._asking = ReentrantCallbackGroup()
        self.create_service(Observe, "perception/observe", self._on_observe, callback_group=self._asking)
        self.create_timer(1.0, self._on_report)
        classes = ", ".join(c.name for c in self._config.knowledge.classes)
        self.get_logger().info(f"ready: input {self._get('input')}, object classes {classes}")

    def _get(self, name: str) -> Any:
        """Value of a parameter."""
        return self.get_parameter(name).value

    def _read_config(self) -> ObserveConfig:
        """The core's config from the parameters; raises MbdError."""
        path = self._get("knowledge") or f"{get_package_share_directory('mbd_perception')}/config/knowledge.yaml"
        limits = []
        for name in ("workspace_x", "workspace_y", "workspace_z"):
            value = self._get(name)
            if len(value) != 2:
                raise MbdError(f"parameter {name} is {list(value)}, expected two numbers: lowest and highest [m]")
            limits.append((value[0], value[1]))
        noise = self._get("depth_noise")
        return ObserveConfig(
            knowledge=load_knowledge(Path(path)),
            segmentation=SegmentationConfig(
                plane=PlaneConfig(noise=noise),
                jump=JumpConfig(noise=noise),
                workspace=Workspace(*limits),
                min_height=self._get("min_height"),
                min_area=self._get("min_area"),
            ),
            frame_id=self._get("base_frame"),
        )

    def _read_pose(self) -> CameraPose | None:
        """The camera's pose from the parameters, None when it is to be taken from the table; raises MbdError."""
        if self._get("camera_pose") == "table":
            return None
        return pose_from_quaternion(self._get("camera_position"), self._get("camera_orientation"))

    def _on_color(self, msg: Image) -> None:
        """Pair a colour image."""
        self._received["colour"] += 1
        self._on_pair(self._pairs.add_color(time_from_msg(msg.header.stamp), msg))

    def _on_depth(self, msg: Image) -> None:
        """Pair a depth image."""
        self._received["depth"] += 1
        self._on_pair(self._pairs.add_depth(time_from_msg(msg.header.stamp), msg))

    def _on_info(self, msg: CameraInfo) -> None:
        """Remember the camera's optics."""
        self._received["camera_info"] += 1
        self._camera_info = msg

    def _on_pair(self, pair: tuple[Image, Image] | None) -> None:
        """A complete frame, once the optics are known."""
        if pair is not None and self._camera_info is not None:
            self._on_moment(time_from_msg(pair[1].header.stamp), (*pair, self._camera_info))

    def _on_points(self, msg: PointCloud2) -> None:
        """A cloud is a frame of its own."""
        self._received["points"] += 1
        self._on_moment(time_from_msg(msg.header.stamp), msg)

    def _on_moment(self, stamp: float, moment: Moment) -> None:
        """Hand a frame to the observations that wait for one."""
        self._received["frames"] += 1
        self._newest = stamp
        for collector, done in list(self._waiting):
            if collector.offer(stamp, moment) and not done.done():
                done.set_result(True)

    async def _on_observe(self, request: Observe.Request, response: Observe.Response) -> Observe.Response:
        """Look at the table; answers success=false with the reason rather than failing."""
        try:
            role = role_from_code(request.role)
            moments = await self._next_moments()
            started = time.perf_counter()
            observation = observe(fuse([_to_frame(m) for m in moments]), role, self._pose, self._config)
        except MbdError as error:
            self._problem = str(error)
            self.get_logger().warning(f"observation failed: {error}")
            response.success, response.message = False, str(error)
            return response
        self._last, self._problem = observation, ""
        self._latency = time.perf_counter() - started
        response.scene = scene_to_msg(observation.scene, observation.table_in_base)
        response.success, response.message = True, observation.summary
        self._scenes[role].publish(response.scene)
        self._markers.publish(scene_markers(observation.scene, observation.table_in_base))
        self.get_logger().info(f"{role} scene: {observation.summary}")
        return response

    async def _next_moments(self) -> list[Moment]:
        """The next frames stamped after now; raises FrameError when they do not come in time."""
        now = time_from_msg(self.get_clock().now().to_msg())
        collector: FrameCollector[Moment] = FrameCollector(earliest_stamp(now, self._newest), self._get("frames"))
        before = dict(self._received)
        done = Future()
        entry = (collector, done)
        self._waiting.append(entry)
        # A steady clock: simulated time may stand still.
        timer = self.create_timer(
            self._get("timeout"), lambda: done.done() or done.set_result(False), self._asking, _STEADY
        )
        try:
            complete = await done
        finally:
            self._waiting.remove(entry)
            self.destroy_timer(timer)
        if not complete:
            raise FrameError(self._why_no_frames(before, collector))
        return collector.frames

    def _why_no_frames(self, before: dict[str, int], collector: FrameCollector[Moment]) -> str:
        """What was missing while an observation waited in vain."""
        came = {key: self._received[key] - count for key, count in before.items()}
        waited = f"within {self._get('timeout'):g} s"
        if self._get("input") == "points" and came["points"] == 0:
            return f"no point cloud arrived {waited} on camera/points: start the camera, or set input to 'images'"
        if self._get("input") == "images":
            topics = {
                "colour": "camera/color/image_raw",
                "depth": "camera/depth/image_raw",
                "camera_info": "camera/color/camera_info",
            }
            missing = [f"{kind} ({topic})" for kind, topic in topics.items() if came[kind] == 0]
            if missing:
                return f"no {', '.join(missing)} arrived {waited}: start the camera and check the topic names"
            if came["frames"] == 0:
                return (
                    f"{came['colour']} colour and {came['depth']} depth images arrived {waited} but no two with the "
                    f"same time stamp (tolerance {self._get('sync_tolerance'):g} s): check the camera's synchronisation"
                )
        return (
            f"{len(collector.frames)} of {collector.wanted} frames arrived {waited}"
            + (f", and {collector.refused} stamped before the request" if collector.refused else "")
            + ": is the camera too slow, or do its clock and use_sim_time differ from this node's?"
        )

    def _on_report(self) -> None:
        """Diagnostics once a second."""
        now = time.monotonic()
        rate = (self._received["frames"] - self._frames_reported) / max(now - self._reported_at, 1e-3)
        self._frames_reported, self._reported_at = self._received["frames"], now
        problem = self._problem or ("" if rate > 0 else "no frames from the camera")
        values = {
            "frame rate [Hz]": f"{rate:.1f}",
            "latency of the last observation [ms]": f"{1e3 * self._latency:.1f}",
            "table found": str(self._last is not None),
            "objects": str(0 if self._last is None else len(self._last.scene.objects)),
        }
        report = DiagnosticArray(status=[status("perception", problem, values)])
        report.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(report)


_STEADY = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)


def _to_frame(moment: Moment) -> RgbdFrame:
    """A frame from its messages; raises FrameError."""
    return frame_from_images(*moment) if isinstance(moment, tuple) else frame_from_cloud_msg(moment)


def _descriptor(spec: ParameterSpec) -> ParameterDescriptor:
    """Description and range of a parameter."""
    descriptor = ParameterDescriptor(description=spec.description, read_only=True)
    if spec.choices:
        descriptor.additional_constraints = f"one of {', '.join(spec.choices)}"
    if spec.range is not None and isinstance(spec.default, int):
        descriptor.integer_range = [IntegerRange(from_value=int(spec.range[0]), to_value=int(spec.range[1]), step=1)]
    elif spec.range is not None:
        descriptor.floating_point_range = [FloatingPointRange(from_value=spec.range[0], to_value=spec.range[1])]
    return descriptor


def main() -> None:
    """Run the node until it is told to stop."""
    cv2.setNumThreads(1)
    rclpy.init()
    try:
        node = PerceptionNode()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        executor.spin()
    except MbdError as error:
        rclpy.logging.get_logger("perception").fatal(str(error))
        raise SystemExit(2) from error
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
