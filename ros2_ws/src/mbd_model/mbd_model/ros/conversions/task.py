"""Between demonstrated tasks with their steps and mbd_msgs/Task."""

from __future__ import annotations

from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from mbd_msgs import msg as m

from mbd_model.ros.conversions.scene import scene_from_msg, scene_to_msg
from mbd_model.ros.conversions.times import header, time_from_msg, time_to_msg
from mbd_model.task import StepKind, Task, TaskStep


def step_to_msg(value: TaskStep) -> m.TaskStep:
    """One step of a task."""
    px, py, pz = value.tool_position
    qx, qy, qz, qw = value.tool_quaternion
    return m.TaskStep(
        index=value.index,
        kind=int(value.kind),
        primary_object=value.primary_object,
        distance=value.distance,
        runner_up=value.runner_up,
        runner_up_distance=value.runner_up_distance,
        start=time_to_msg(value.start),
        end=time_to_msg(value.end),
        tool_pose=Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw)),
        offset=Vector3(x=value.offset[0], y=value.offset[1], z=value.offset[2]),
    )


def step_from_msg(msg: m.TaskStep, doubt: float = 0.0) -> TaskStep:
    """One step of a task; ``doubt`` about it is kept beside the steps."""
    position, orientation = msg.tool_pose.position, msg.tool_pose.orientation
    return TaskStep(
        index=int(msg.index),
        kind=StepKind(msg.kind),
        primary_object=msg.primary_object,
        distance=float(msg.distance),
        runner_up=msg.runner_up,
        runner_up_distance=float(msg.runner_up_distance),
        start=time_from_msg(msg.start),
        end=time_from_msg(msg.end),
        tool_position=(float(position.x), float(position.y), float(position.z)),
        tool_quaternion=(float(orientation.x), float(orientation.y), float(orientation.z), float(orientation.w)),
        offset=(float(msg.offset.x), float(msg.offset.y), float(msg.offset.z)),
        doubt=doubt,
    )


def task_to_msg(value: Task) -> m.Task:
    """A demonstrated task."""
    return m.Task(
        header=header(value.stamp, value.source.frame_id),
        source=scene_to_msg(value.source),
        steps=[step_to_msg(s) for s in value.steps],
        problems=list(value.problems),
        open_ends=list(value.open_ends),
        doubts=[s.doubt for s in value.steps],
    )


def task_from_msg(msg: m.Task) -> Task:
    """A demonstrated task; raises MbdError when a step names an object its source scene lacks."""
    # An older version's task has no doubts.
    doubts = [float(d) for d in msg.doubts] or [0.0] * len(msg.steps)
    return Task(
        source=scene_from_msg(msg.source),
        steps=tuple(step_from_msg(s, d) for s, d in zip(msg.steps, doubts, strict=True)),
        problems=tuple(msg.problems),
        stamp=time_from_msg(msg.header.stamp),
        open_ends=tuple(int(k) for k in msg.open_ends),
    )
