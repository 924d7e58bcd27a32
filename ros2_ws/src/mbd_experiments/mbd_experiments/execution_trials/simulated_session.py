"""The work in a simulated cell of this process, without ROS: from two looks at the table and a demonstration on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from mbd_cell.arm.hand import GripperCommand
from mbd_cell.arm.kinematics import DownwardToolPose, UnreachableError
from mbd_cell.cell import Cell
from mbd_cell.layout.scenes import TaskScenes
from mbd_cell.outcome import ObjectState, object_states
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word
from mbd_execution.choosing import next_motion
from mbd_execution.execution import Work, motion_ended
from mbd_execution.goals import Ended, Grip, Look, Motion, ToolGoal
from mbd_model.objects import Role, Scene
from mbd_model.session import Phase
from mbd_model.stop import MotionError
from mbd_model.task import Task
from mbd_perception.features.measure import ObserveConfig

from mbd_experiments.in_process_session import InProcessSession

ARRIVED = 0.01  # [m]
ONE_LOOK = (1, 30)  # frames of an observation, and ticks before it


@dataclass(frozen=True)
class Shown:
    """A session of the cell up to the point from which the robot executes the task alone.

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


def show(scenes: TaskScenes, seed: int, perception: ObserveConfig) -> Shown:
    """Look at the source table, demonstrate, and look at the target table, with the camera's noise.

    Args:
        scenes: of the task.
        seed: of layouts, the teacher's hand and the camera's noise.
        perception: how scenes are seen.
    """
    session = InProcessSession(scenes, seed, perception)
    source = session.observe(Role.SOURCE, *ONE_LOOK).scene
    names = {Role.SOURCE: session.true_names(source)}
    session.stage.enter(Phase.DEMONSTRATE)
    task = _demonstrated(session, source)
    left = object_states(session.cell.simulation)
    session.stage.enter(Phase.TUCK_AND_CLEAR)
    session.until(Word.READY)
    target = session.observe(Role.TARGET, *ONE_LOOK).scene
    names[Role.TARGET] = session.true_names(target)
    return Shown(session.cell, task, target, names, left)


def _demonstrated(session: InProcessSession, source: Scene) -> Task:
    """The teacher's demonstration as the demonstration node reads it, a wizard answering each word at once."""
    session.until(Word.DEMONSTRATION_BEGINS)
    session.start_recording(source)
    session.stage.begin()
    while (word := session.until(*ANSWERED_BY_GRIPPER, Word.DEMONSTRATION_ENDS)) in ANSWERED_BY_GRIPPER:
        session.grip(word)
    while session.cell.busy:
        session.tick()
    return session.stop_recording()


class Ticking(Protocol):
    """What lets time pass in a cell: the cell itself, or a session of it."""

    def tick(self) -> object:
        """Let 10 ms pass."""


def execute(work: Work, cell: Cell) -> Work:
    """Do the work in the cell until it is done or needs an assist."""
    while True:
        work, motion = next_motion(work, allowed=True)
        if motion is None:
            return work
        work = motion_ended(work, do(motion, cell, cell))


def do(motion: Motion, cell: Cell, time: Ticking) -> Ended:
    """Make one motion in the cell.

    Args:
        motion: to be made.
        cell: where.
        time: what lets its time pass.
    """
    if isinstance(motion, Look):
        return Ended(
            False, message="nobody looks here: work that looks is done by a session", error=MotionError.NOT_REACHED
        )
    if isinstance(motion, Grip):
        cell.move_gripper(GripperCommand.CLOSE if motion.close else GripperCommand.OPEN)
        _run(cell, time)
        return Ended(True, holding=cell.fingers_stopped, reached=_tool(cell))
    goal = motion.goal
    try:
        cell.move_tool(DownwardToolPose(goal.x, goal.y, goal.z, goal.yaw, goal.tilt), motion.speed)
        _run(cell, time)
    except UnreachableError as error:
        return Ended(False, message=str(error), reached=_tool(cell), error=MotionError.NOT_REACHED)
    apart = float(np.linalg.norm(np.subtract(cell.simulation.tool.position, (goal.x, goal.y, goal.z))))
    if apart < ARRIVED:
        return Ended(True, reached=_tool(cell))
    why = f"stopped {apart:.3f} m before the goal"
    return Ended(False, message=why, reached=_tool(cell), error=MotionError.NOT_REACHED)


def right_mapping(shown: Shown) -> dict[str, str]:
    """Perceived source id -> perceived target id, each target once, preferred answers first."""
    ids = {name: perceived for perceived, name in shown.names[Role.TARGET].items()}
    mapping: dict[str, str] = {}
    for source_id, name in shown.names[Role.SOURCE].items():
        free = [ids[t] for t in shown.cell.scenes.solution[name] if t in ids and ids[t] not in mapping.values()]
        if free:
            mapping[source_id] = free[0]
    return mapping


def _tool(cell: Cell) -> ToolGoal:
    pose = cell.arm.pose
    return ToolGoal(pose.x, pose.y, pose.z, pose.yaw, pose.tilt)


def _run(cell: Cell, time: Ticking) -> None:
    while cell.busy:
        time.tick()
