"""What is collected while a demonstration runs, until it is read as a task."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum

from mbd_model.errors import MbdError
from mbd_model.objects import Scene
from mbd_model.task import Task

from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.finger_joint import FingerJointConfig, GripperReading, read_gripper
from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.segmentation import SegmentationProgress, segment
from mbd_demonstration.trajectory import ToolTrajectory


class GripperSource(StrEnum):
    """Where gripper events come from: the wizard's toggles on the teacher's word, or the finger joint."""

    SPOKEN = "spoken"
    JOINT = "joint"


@dataclass(frozen=True)
class DemonstrationConfig:
    """Everything that decides how a recording becomes a task."""

    gripper_source: GripperSource = GripperSource.SPOKEN
    finger: FingerJointConfig = field(default_factory=FingerJointConfig)
    segmentation: StepSegmentationConfig = field(default_factory=StepSegmentationConfig)


@dataclass
class Recording:
    """A demonstration while it runs.

    Attributes:
        scene: the source scene it is demonstrated in.
        begin: when it began [s].
        so_far: steps of an earlier recording that this one goes on from.
    """

    scene: Scene
    begin: float
    so_far: SegmentationProgress | None = None
    _stamps: list[float] = field(default_factory=list)
    _positions: list[tuple[float, float, float]] = field(default_factory=list)
    _quaternions: list[tuple[float, float, float, float]] = field(default_factory=list)
    _joint_stamps: list[float] = field(default_factory=list)
    _joint: list[float] = field(default_factory=list)
    _events: list[GripperEvent] = field(default_factory=list)
    _foreign_frames: dict[str, int] = field(default_factory=dict)

    def add_pose(
        self,
        stamp: float,
        frame_id: str,
        position: tuple[float, float, float],
        quaternion: tuple[float, float, float, float],
    ) -> None:
        """Add a tool pose [s; m; x, y, z, w]; one in another frame than the scene's is counted, not used."""
        if frame_id != self.scene.frame_id:
            self._foreign_frames[frame_id] = self._foreign_frames.get(frame_id, 0) + 1
            return
        self._stamps.append(stamp)
        self._positions.append(position)
        self._quaternions.append(quaternion)

    def add_finger(self, stamp: float, position: float) -> None:
        """Add a finger joint position."""
        self._joint_stamps.append(stamp)
        self._joint.append(position)

    def add_event(self, event: GripperEvent) -> None:
        """Add a spoken gripper event."""
        self._events.append(event)

    def task(self, stamp: float, config: DemonstrationConfig) -> Task:
        """The task recorded up to ``stamp`` [s].

        Raises:
            MbdError: no usable tool pose was recorded.
        """
        if not self._stamps and self._foreign_frames:
            raise MbdError(
                f"every tool pose came in another frame ({sorted(self._foreign_frames)}) than the source scene "
                f"('{self.scene.frame_id}'): both must be in the robot's base frame"
            )
        trajectory = ToolTrajectory.from_samples(self._stamps, self._positions, self._quaternions)
        events: tuple[GripperEvent, ...] = tuple(self._events)
        reading = GripperReading(events)
        if config.gripper_source is GripperSource.JOINT:
            if not self._joint:
                raise MbdError("no finger joint position was recorded: check finger_joints against out/joint_state")
            reading = read_gripper(self._joint_stamps, self._joint, config.finger)
        return understood(trajectory, reading, self.scene, stamp=stamp, config=config.segmentation, so_far=self.so_far)


def understood(
    trajectory: ToolTrajectory,
    reading: GripperReading,
    scene: Scene,
    *,
    stamp: float,
    config: StepSegmentationConfig | None = None,
    so_far: SegmentationProgress | None = None,
) -> Task:
    """The task of a trajectory and what the gripper did, with all that was no step among its problems; see segment."""
    task = segment(
        trajectory,
        reading.events,
        scene,
        stamp=stamp,
        config=config,
        so_far=so_far,
        started_closed=reading.started_closed,
    )
    return _with_half_closings(task, reading, float(trajectory.stamps[0]))


def _with_half_closings(task: Task, reading: GripperReading, begin: float) -> Task:
    """The task with each half-closing of the finger joint among its problems; ``begin`` is the recording's [s]."""
    stated = tuple(
        f"at {stamp - begin:.1f} s the gripper closed to {closure:.0%} only and opened again: not a step "
        "(had it hold of something wide, give finger_open_level and finger_closed_level)"
        for stamp, closure in reading.half_closings
    )
    return replace(task, problems=task.problems + stated)
