"""Node ``perception``: camera in, scenes out."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
from ament_index_python.packages import get_package_share_directory
from diagnostic_msgs.msg import DiagnosticArray
from mbd_model.errors import MbdError
from mbd_model.objects import Role, SceneObject
from mbd_model.ros.conversions import role_from_code, scene_from_msg, scene_to_msg
from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import EVENTS, IMAGES, LATCHED, SENSOR
from mbd_model.ros.run_node import run_node
from mbd_msgs.msg import Scene
from mbd_msgs.srv import Observe
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.logging import get_logging_directory
from sensor_msgs.msg import Image
from visualization_msgs.msg import MarkerArray

from mbd_perception.config import observe_config
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import Observation, observe, with_tables
from mbd_perception.frames.evidence import keep_evidence
from mbd_perception.frames.frame import RgbdFrame, fuse
from mbd_perception.overlay import draw_overlay
from mbd_perception.parameters import PERCEPTION
from mbd_perception.ros.arm_intake import ArmIntake
from mbd_perception.ros.camera_intake import CameraIntake, Moment, camera_frame_id, serialized, to_frame
from mbd_perception.ros.camera_pose import pose_source
from mbd_perception.ros.conversions import color_to_msg, scene_markers, status
from mbd_perception.segmentation.table.beside import TablesInView
from mbd_perception.segmentation.table.plane import Plane
from mbd_perception.segmenters.segmenter import SegmenterError


class PerceptionNode(TableNode):
    """Answers ``perception/observe``, latches the scenes it saw, and shows live what it sees to whoever listens.

    One thread serves everything: the service handler is a coroutine that waits for its frames without blocking their
    subscriptions.
    """

    def __init__(self, **options: Any) -> None:
        """``options`` go to rclpy's Node (parameter_overrides, namespace…)."""
        super().__init__(PERCEPTION, **options)
        path = self._get("knowledge") or f"{get_package_share_directory('mbd_perception')}/config/knowledge.yaml"
        self._config = observe_config(self.values, load_knowledge(Path(path)))
        self._pose = pose_source(self, self.values)
        self._arm = ArmIntake(self, self._get("arm_description"), self._get("joint_state"), self._get("base_frame"))
        self._role = Role.SOURCE
        self._last: Observation | None = None
        self._tables: TablesInView | None = None
        self._arm_seen = False
        self._live_objects: tuple[SceneObject, ...] = ()
        self._problem = ""
        self._latency = 0.0
        self._frames_reported, self._reported_at = 0, time.monotonic()
        state_dir = self._get("state_dir")
        self._scenes = {role: LatchedPublisher(self, Scene, f"perception/{role}_scene", state_dir) for role in Role}
        self._markers = self.create_publisher(MarkerArray, "perception/markers", LATCHED)
        self._image = self.create_publisher(Image, "perception/image", LATCHED)
        self._live_scene = self.create_publisher(Scene, "perception/live_scene", SENSOR)
        self._live_image = self.create_publisher(Image, "perception/live_image", IMAGES)
        self._diagnostics = self.create_publisher(DiagnosticArray, "diagnostics", EVENTS)
        points = self._get("input") == "points"
        self._camera = CameraIntake(
            self, points, self._get("image_transport"), self._get("sync_tolerance"), self._on_moment
        )
        # A waiting handler holds its callback group: in the node's own it would shut out the frames it waits for.
        self.create_service(Observe, "perception/observe", self._on_observe, callback_group=ReentrantCallbackGroup())
        self.create_timer(1.0, self._on_report)
        classes = ", ".join(c.name for c in self._config.knowledge.classes)
        self.get_logger().info(f"ready: input {self._get('input')}, object classes {classes}")

    def _get(self, name: str) -> Any:
        """Value of a parameter."""
        return self.values[name]

    async def _on_observe(self, request: Observe.Request, response: Observe.Response) -> Observe.Response:
        """Look at the table; answers success=false with the reason rather than failing.

        With ``answer_only`` the scenes that others work by stay as they are.
        """
        frame, moments = None, []
        try:
            role = role_from_code(request.role)
            moments = await self._camera.next_moments(self._get("frames"), self._get("timeout"))
            started = time.perf_counter()
            frame = fuse([to_frame(m) for m in moments])
            pose = self._pose.of(camera_frame_id(moments[-1]))
            known = () if request.answer_only else self._known(role)
            observation = observe(frame, role, pose, self._config, known, last=self._table(), arm=self._arm.rods)
            observation = with_tables(observation)
            self._tables = observation.tables
            self._latency = time.perf_counter() - started
            if not request.answer_only:
                self._show(observation, role, camera_frame_id(moments[-1]))
            response.scene = scene_to_msg(observation.scene, observation.table_in_base)
        except Exception as error:  # whatever is in a frame, the node answers and lives on
            self._problem = self._reason(error, frame, moments)
            self.get_logger().warning(f"observation failed: {self._problem}")
            response.success, response.message = False, self._problem
            return response
        self._role, self._last, self._problem = role, observation, ""
        self._arm_seen = bool(observation.arm)
        if not request.answer_only:
            self._live_objects = observation.scene.objects
        response.success, response.message = True, observation.summary
        self.get_logger().info(f"{role} scene: {observation.summary}")
        return response

    def _show(self, observation: Observation, role: Role, camera_frame: str) -> None:
        """Publish an observation; nothing of it, when one of its messages cannot be made."""
        scene = scene_to_msg(observation.scene, observation.table_in_base)
        markers = scene_markers(observation.scene, observation.table_in_base)
        picture = color_to_msg(draw_overlay(observation), observation.frame.stamp, camera_frame)
        self._scenes[role].publish(scene)
        self._markers.publish(markers)
        self._image.publish(picture)

    def _reason(self, error: Exception, frame: RgbdFrame | None, moments: Sequence[Moment]) -> str:
        """Why there is no scene; the frame is kept when nobody expected that."""
        if isinstance(error, MbdError) and not isinstance(error, SegmenterError):
            return str(error)
        if not self.context.ok():
            raise error  # nothing is wrong with the frame: the node is being ended
        folder = Path(self._get("state_dir") or get_logging_directory()) / "failed_frames"
        kept = keep_evidence(folder, error, frame, serialized(moments[-1]) if moments else None)
        where = f"the frame is kept in {kept}" if kept else f"{folder} holds earlier ones; empty it to keep more"
        ours = f"this frame cannot be seen through ({type(error).__name__}: {error}): please report it"
        text = f"{error if isinstance(error, SegmenterError) else ours}; {where}"
        self.get_logger().error(text, throttle_duration_sec=10.0)
        return text

    def _table(self) -> Plane | None:
        """The table in the last frame; None before the first."""
        return None if self._last is None else self._last.segmentation.plane

    def _known(self, role: Role) -> tuple[SceneObject, ...]:
        """The objects of the last scene of that role, from before a restart too; none when ids are not kept."""
        last = self._scenes[role].last
        return () if last is None or not self._get("keep_ids") else scene_from_msg(last).objects

    def _on_moment(self, moment: Moment) -> None:
        """Show what the camera sees now, to whoever listens; otherwise spend nothing on it."""
        scene_wanted = self._live_scene.get_subscription_count() > 0
        image_wanted = self._live_image.get_subscription_count() > 0
        if not scene_wanted and not image_wanted:
            return
        started = time.perf_counter()
        frame = None
        try:
            pose = self._pose.of(camera_frame_id(moment))
            frame = to_frame(moment)
            observation = observe(
                frame, self._role, pose, self._config, self._live_objects, last=self._table(), arm=self._arm.rods
            )
            if scene_wanted:
                self._live_scene.publish(scene_to_msg(observation.scene, observation.table_in_base))
            if image_wanted:
                picture = draw_overlay(observation)
                self._live_image.publish(color_to_msg(picture, observation.scene.stamp, camera_frame_id(moment)))
        except Exception as error:  # whatever is in a frame, the node lives on
            self._problem = self._reason(error, frame, [moment])
            return
        self._problem, self._last, self._live_objects = "", observation, observation.scene.objects
        self._latency = time.perf_counter() - started

    def _on_report(self) -> None:
        """Diagnostics once a second."""
        now, frames = time.monotonic(), self._camera.counts.frames
        rate = (frames - self._frames_reported) / max(now - self._reported_at, 1e-3)
        self._frames_reported, self._reported_at = frames, now
        problem = self._problem or ("" if rate > 0 else "no frames from the camera")
        values = {
            "frame rate [Hz]": f"{rate:.1f}",
            "latency of the last observation [ms]": f"{1e3 * self._latency:.1f}",
            "table found": str(self._last is not None),
            "tables in view": "0" if self._tables is None else str(1 + len(self._tables.others)),
            "other tables": "" if self._tables is None else self._tables.hint,
            "arm": "not known" if self._arm.rods is None else "in view" if self._arm_seen else "not in view",
            "streams": self._camera.asked,
            "objects": str(0 if self._last is None else len(self._last.scene.objects)),
        }
        report = DiagnosticArray(status=[status("perception", problem, values)])
        report.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(report)


def main() -> None:
    """Run the node until it is asked to stop."""
    cv2.setNumThreads(1)
    run_node("perception", PerceptionNode)


if __name__ == "__main__":
    main()
