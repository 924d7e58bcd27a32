"""The teacher's corrections as they are asked for by service (mbd_msgs/ReviseTask)."""

from __future__ import annotations

from collections.abc import Callable

from mbd_model.errors import MbdError
from mbd_model.ros.conversions import time_from_msg
from mbd_model.task import Task
from mbd_msgs.srv import ReviseTask
from rclpy.node import Node

from mbd_demonstration.revision import deleted, joined_steps, moved, split, with_object
from mbd_demonstration.trajectory import ToolTrajectory


def corrected(task: Task, request: ReviseTask.Request, now: float, path: ToolTrajectory | None) -> Task:
    """The task with one step corrected.

    Args:
        task: as it is.
        request: what to change; RERECORD is the node's.
        now: time of the correction [s].
        path: of the tool as the task was recorded, if that is known.

    Raises:
        MbdError: it cannot be corrected so.
    """
    index = int(request.step)
    if request.change == ReviseTask.Request.DELETE:
        return deleted(task, index, now)
    if request.change == ReviseTask.Request.MOVE:
        return moved(task, index, int(request.to), now)
    if request.change == ReviseTask.Request.CHANGE_OBJECT:
        return with_object(task, index, request.object, now)
    if request.change == ReviseTask.Request.JOIN:
        return joined_steps(task, index, now)
    if request.change == ReviseTask.Request.SPLIT:
        if path is None:
            raise MbdError("where the tool went is no longer known: this node was started after the demonstration")
        at = time_from_msg(request.at)
        return split(task, index, path.pose_at(at), at, now)
    raise MbdError(f"change {request.change} is unknown; expected one of the constants of ReviseTask")


def answered(node: Node, answer: Callable[[], str]) -> tuple[str, bool]:
    """(message, success) of a service: what ``answer`` returns, or the MbdError it raises; both are logged."""
    try:
        message = answer()
    except MbdError as error:
        node.get_logger().warning(str(error))
        return str(error), False
    node.get_logger().info(message)
    return message, True
