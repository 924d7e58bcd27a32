"""The work in a simulated cell of this process, without ROS: from two looks at the table and a demonstration on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mbd_cell.arm.hand import GripperCommand
from mbd_cell.arm.kinematics import DownwardToolPose, UnreachableError
from mbd_cell.cell import Cell
from mbd_cell.layout.scenes import TaskScenes
from mbd_cell.outcome import ObjectState
from mbd_cell.physics.camera import INTRINSICS, Camera
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.teacher.recognition import recognise
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.segmentation import segment
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_execution.choosing import next_motion
from mbd_execution.execution import Work, motion_ended
from mbd_execution.goals import Ended, Grip, Motion, ToolGoal
from mbd_model.objects import Role, Scene
from mbd_model.task import Task
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.frames.frame import make_frame
from mbd_perception.segmentation.segment import SegmentationConfig, Workspace

ARRIVED = 0.01  # [m]
POSE_EVERY = 3  # ticks between two recorded tool poses
WORKSPACE = Workspace((0.16, 0.86), (-0.6, 0.6))  # as config/camera.yaml of the cell has it


@dataclass(frozen=True)
class Shown:
    """A session of the cell up to the point from which the robot carries on alone.

    Attributes:
        cell: with the target set on its table.
        task: as demonstrated.
        target: the target objects as seen.
        names: true name by perceived id, of either scene.
        left: the source objects as the demonstration left them.
    """

    cell: Cell
    task: Task
    target: Scene
    names: Mapping[Role, Mapping[str, str]]
    left: Mapping[str, ObjectState]


def show(scenes: TaskScenes, seed: int, knowledge: Path) -> Shown:
    """Look at the source table, demonstrate, and look at the target table, with the camera's noise.

    Args:
        scenes: of the task.
        seed: of layouts, the teacher's hand and the camera's noise.
        knowledge: perception's knowledge base.
    """
    cell = Cell(scenes, seed, CELL_CAMERA)
    source = look(cell, knowledge)
    names = {Role.SOURCE: _recognised(cell, source)}
    task = _demonstrate(cell, source)
    left = standing_objects(cell)
    cell.tuck()
    _run(cell)
    cell.lay(Role.TARGET, seed)
    target = look(cell, knowledge)
    names[Role.TARGET] = _recognised(cell, target)
    return Shown(cell, task, target, names, left)


def look(cell: Cell, knowledge: Path) -> Scene:
    """What perception sees of the table now."""
    for _ in range(30):
        cell.tick()
    with Camera(cell.model) as camera:
        picture = camera.render(cell.simulation, cell.image_rng())
    frame = make_frame(picture.color, picture.depth_mm, INTRINSICS, cell.time_ns / 1e9)
    config = ObserveConfig(load_knowledge(knowledge), SegmentationConfig(workspace=WORKSPACE))
    return observe(frame, cell.role, CELL_CAMERA, config).scene


def carry_out(work: Work, cell: Cell) -> Work:
    """Do the work in the cell until it is done or needs to be told something."""
    while True:
        work, motion = next_motion(work, allowed=True)
        if motion is None:
            return work
        work = motion_ended(work, do(motion, cell))


def do(motion: Motion, cell: Cell) -> Ended:
    """Make one motion in the cell."""
    if isinstance(motion, Grip):
        cell.move_gripper(GripperCommand.CLOSE if motion.close else GripperCommand.OPEN)
        _run(cell)
        return Ended(True, holding=cell.holding is not None, reached=_tool(cell))
    goal = motion.goal
    try:
        cell.move_tool(DownwardToolPose(goal.x, goal.y, goal.z, goal.yaw), motion.speed)
        _run(cell)
    except UnreachableError as error:
        return Ended(False, message=str(error), reached=_tool(cell))
    apart = float(np.linalg.norm(np.subtract(cell.simulation.tool.position, (goal.x, goal.y, goal.z))))
    return Ended(apart < ARRIVED, message=f"stopped {apart:.3f} m before the goal", reached=_tool(cell))


def standing_objects(cell: Cell) -> dict[str, ObjectState]:
    """Every object on the table as it is."""
    return {name: ObjectState(cell.simulation.object_pose(name), o.size) for name, o in cell.simulation.objects.items()}


def right_mapping(shown: Shown) -> dict[str, str]:
    """Perceived source id -> perceived target id, each target once, preferred answers first."""
    ids = {name: perceived for perceived, name in shown.names[Role.TARGET].items()}
    mapping: dict[str, str] = {}
    for source_id, name in shown.names[Role.SOURCE].items():
        free = [ids[t] for t in shown.cell.scenes.solution[name] if t in ids and ids[t] not in mapping.values()]
        if free:
            mapping[source_id] = free[0]
    return mapping


def _recognised(cell: Cell, scene: Scene) -> dict[str, str]:
    places = {name: cell.simulation.object_pose(name).position[:2] for name in cell.simulation.objects}
    return recognise(scene, places)


def _tool(cell: Cell) -> ToolGoal:
    pose = cell.arm.pose
    return ToolGoal(pose.x, pose.y, pose.z, pose.yaw)


def _run(cell: Cell) -> None:
    while cell.busy:
        cell.tick()


def _demonstrate(cell: Cell, source: Scene) -> Task:
    """The teacher's demonstration as the demonstration node reads it, a wizard answering each word at once."""
    events, stamps, positions, quaternions = [], [], [], []
    cell.demonstrate()
    ticks = 0
    while cell.busy:
        cell.tick()
        if ticks % POSE_EVERY == 0:
            stamps.append(cell.time_ns / 1e9)
            positions.append(cell.simulation.tool.position)
            quaternions.append(cell.simulation.tool.quaternion)
        ticks += 1
        for word in cell.take_spoken():
            if word is Word.DEMONSTRATION_BEGINS:
                cell.begin()
            elif word in ANSWERED_BY_GRIPPER:
                command = ANSWERED_BY_GRIPPER[word]
                events.append(GripperEvent(cell.time_ns / 1e9, GripperAction(int(command))))
                cell.gripper(command)
    trajectory = ToolTrajectory.from_samples(stamps, positions, quaternions)
    return segment(trajectory, events, source, stamp=cell.time_ns / 1e9)
