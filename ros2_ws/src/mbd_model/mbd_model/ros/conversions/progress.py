"""Between the robot's progress and mbd_msgs/Progress."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from mbd_msgs import msg as m

from mbd_model.execution_progress import Failure, Progress, Purpose, Status


def progress_to_msg(value: Progress, session: str, assists_stamp: Time) -> m.Progress:
    """The progress, without its own stamp, of a plan that comes of the assists of that stamp."""
    return m.Progress(
        session=session,
        step_index=value.step_index,
        status=int(value.status),
        text=value.text,
        step_statuses=[int(s) for s in value.step_statuses],
        assists_stamp=assists_stamp,
        purpose=int(value.purpose),
        object_id=value.object_id,
        receiver_id=value.receiver_id,
        failure=int(value.failure),
    )


def progress_from_msg(msg: m.Progress) -> Progress:
    """The progress; raises ValueError for a status, a purpose or a failure there is not."""
    return Progress(
        step_index=int(msg.step_index),
        status=Status(msg.status),
        text=msg.text,
        step_statuses=tuple(Status(s) for s in msg.step_statuses),
        purpose=Purpose(msg.purpose),
        object_id=msg.object_id,
        receiver_id=msg.receiver_id,
        failure=Failure(msg.failure),
    )
