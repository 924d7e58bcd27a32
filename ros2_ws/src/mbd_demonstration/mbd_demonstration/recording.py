"""What is collected while a demonstration runs, until it is read as a task."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.geometry.boxes import nearest
from mbd_model.objects import Scene
from mbd_model.task import Task
from numpy.typing import NDArray

from mbd_demonstration.clocks.stamps import LATE, CheckedStamps, checked, held, joined
from mbd_demonstration.clocks.words import words_dated
from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.finger_joint import FingerJointConfig, GripperReading
from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.hand.fingers import named_fingers
from mbd_demonstration.hand.hands import read_hands
from mbd_demonstration.samples import Samples
from mbd_demonstration.segmentation import SegmentationProgress
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_demonstration.understanding import in_tool_time, understood


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
        wanted: names of the finger joints, with or without a robot's prefix; where none is there, by their names.
        poses: rows of (stamp [s], arrival [s], x, y, z [m], qx, qy, qz, qw).
        fingers: rows of (stamp [s], arrival [s], position) of each finger joint, by name.
        events: spoken gripper commands.
        foreign_frames: how many tool poses came in each other frame than the scene's.
        empty: joint states that had names and no positions, which is legal.
    """

    scene: Scene
    begin: float
    so_far: SegmentationProgress | None = None
    wanted: tuple[str, ...] = ()
    poses: Samples = field(default_factory=lambda: Samples(9))
    fingers: dict[str, Samples] = field(default_factory=dict)
    events: list[GripperEvent] = field(default_factory=list)
    foreign_frames: dict[str, int] = field(default_factory=dict)
    empty: int = 0
    _found: dict[tuple[str, ...], tuple[str, ...]] = field(default_factory=dict)
    # When the tool pose before each word arrived [s].
    _pose_before: dict[GripperEvent, float] = field(default_factory=dict)
    _last_arrival: float = math.nan

    def add_pose(
        self,
        stamp: float,
        frame_id: str,
        position: tuple[float, float, float],
        quaternion: tuple[float, float, float, float],
        arrival: float = math.nan,
    ) -> None:
        """Add a tool pose [s; m; x, y, z, w]; one in another frame than the scene's is counted, not used.

        ``arrival`` is when it came [s], by a clock that never jumps.
        """
        if frame_id != self.scene.frame_id:
            self.foreign_frames[frame_id] = self.foreign_frames.get(frame_id, 0) + 1
            return
        self.poses.add(stamp, arrival, *position, *quaternion)
        self._last_arrival = arrival

    def add_joints(
        self, stamp: float, names: Sequence[str], positions: Sequence[float], arrival: float = math.nan
    ) -> tuple[str, ...]:
        """Add a joint state of any publisher; one without finger joints, or without positions, is left out.

        Returns:
            Names of the finger joints that are new with it.
        """
        key = tuple(names)
        if key not in self._found:
            self._found[key] = named_fingers(key, self.wanted)
        found = self._found[key]
        if not found:
            return ()
        if len(positions) != len(names):
            self.empty += 1
            return ()
        new = tuple(name for name in found if name not in self.fingers)
        for name in found:
            self.fingers.setdefault(name, Samples(3)).add(stamp, arrival, float(positions[key.index(name)]))
        return new

    def add_event(self, event: GripperEvent) -> None:
        """Add a spoken gripper event as it arrives."""
        self._pose_before[event] = self._last_arrival
        self.events.append(event)

    def task(self, stamp: float, config: DemonstrationConfig, *, look: bool = False) -> Task:
        """The task recorded up to ``stamp`` [s].

        Args:
            stamp: time at which it is complete [s].
            config: what decides.
            look: only look while it runs: reads at most LOOK_RATE samples a second.

        Raises:
            MbdError: no usable tool pose was recorded, or none of the fingers that it needs.
        """
        if not len(self.poses) and self.foreign_frames:
            raise MbdError(
                f"every tool pose came in another frame ({sorted(self.foreign_frames)}) than the source scene "
                f"('{self.scene.frame_id}'): both must be in the robot's base frame"
            )
        trajectory, notes = self.trajectory(look=look)
        if self.foreign_frames:
            notes += (f"tool poses in another frame than '{self.scene.frame_id}' were left out: {self.foreign_frames}",)
        if config.gripper_source is GripperSource.JOINT:
            reading, about = self._reading(config.finger, look=look)
            reading, skewed = in_tool_time(reading, trajectory)
            notes += about + skewed
        else:
            reading, about = self._spoken(trajectory, config, look=look)
            notes += about
        return understood(
            trajectory,
            reading,
            self.scene,
            stamp=stamp,
            config=config.segmentation,
            so_far=self.so_far,
            notes=joined(notes),
        )

    def trajectory(self, *, look: bool = False) -> tuple[ToolTrajectory, tuple[str, ...]]:
        """The tool's path, and what is wrong with its stamps."""
        rows, dated = self._dated_poses(look=look)
        path = ToolTrajectory.from_samples(dated.stamps, rows[:, 2:5], rows[:, 5:9])
        return path, (*dated.notes, *held(path.stamps, path.positions, "the tool pose"))

    def _dated_poses(self, *, look: bool) -> tuple[NDArray[np.float64], CheckedStamps]:
        """The rows of the tool poses, and their stamps looked at."""
        rows = self.poses.table(thin=look)
        return rows, checked(rows[:, 0], "the tool poses", _known(rows[:, 1]))

    def _words(self, *, look: bool) -> list[GripperEvent]:
        """The words in order, by the time that the tool poses are given: a clock that was set back was so for both."""
        rows, dated = self._dated_poses(look=look)
        words = []
        known = _known(rows[:, 1]) is not None
        for word in self.events:
            before = self._pose_before.get(word, math.nan)
            moved = 0.0
            if known and math.isfinite(before):
                pose = max(int(np.searchsorted(rows[:, 1], before, side="right")) - 1, 0)
                by = float(dated.stamps[pose] - rows[pose, 0])
                # Only of a word by that clock: another machine's went on.
                if abs(by) > LATE and abs(word.stamp - rows[pose, 0]) < abs(word.stamp - dated.stamps[pose]):
                    moved = by
            words.append(replace(word, stamp=word.stamp + moved))
        return sorted(words, key=lambda e: e.stamp)

    def _reading(self, config: FingerJointConfig, *, look: bool) -> tuple[GripperReading, tuple[str, ...]]:
        """What the fingers show, and what was wrong with them."""
        notes: tuple[str, ...] = ()
        if self.empty:
            notes += (f"{self.empty} joint states had names and no positions: left out",)
        used = named_fingers(tuple(self.fingers), self.wanted)
        if not used:
            raise MbdError(
                "no finger joint position was recorded: check finger_joints against out/joint_state"
                + (f" ({notes[0]})" if notes else "")
            )
        series = {}
        for name in used:
            rows = self.fingers[name].table(thin=look)
            dated = checked(rows[:, 0], f"'{name}'", _known(rows[:, 1]))
            notes += dated.notes
            series[name] = (dated.stamps, rows[:, 2])
        reading, about = read_hands(series, config)
        return reading, notes + about

    def _spoken(
        self, trajectory: ToolTrajectory, config: DemonstrationConfig, *, look: bool
    ) -> tuple[GripperReading, tuple[str, ...]]:
        """Spoken commands where they were carried out: by the fingers, if they were recorded, or the tool's rests."""
        fingers: tuple[GripperEvent, ...] = ()
        skewed: tuple[str, ...] = ()
        if self.fingers:
            try:
                reading, skewed = in_tool_time(self._reading(config.finger, look=look)[0], trajectory)
                # By another clock, even one that is mended, they say less than the words and the tool's rests.
                fingers = () if skewed else reading.events
            except MbdError:
                fingers = ()  # the words alone must do, as they did

        def near_object(stamp: float) -> bool:
            order = nearest(trajectory.pose_at(stamp).position, self.scene.objects)
            return bool(order) and order[0][0] <= config.segmentation.grasp_reach

        events, notes = words_dated(self._words(look=look), trajectory, fingers, near_object)
        return GripperReading(events), notes + skewed


def _known(arrivals: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Arrival times where every one is known, else None."""
    return arrivals if arrivals.size and bool(np.isfinite(arrivals).all()) else None
