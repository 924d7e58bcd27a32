"""A session's task once more, from the tool's path and the gripper: the stage between scenes and assists."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from mbd_bag.formats.contents import BagMessage
from mbd_bag.recorder.thinning import header_stamp
from mbd_bag.session.recorded_session import Recorded, RecordedSession
from mbd_bag.session.session_facts import recorded_parameters
from mbd_bag.storage.bag import Bag
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.parameters import DEMONSTRATION, demonstration_config
from mbd_demonstration.recording import DemonstrationConfig, Recording
from mbd_model.errors import MbdError
from mbd_model.task import Task
from mbd_model.times import to_seconds

from mbd_study.recompute.given_parameters import require_parameters
from mbd_study.recompute.stages import StageCheck, task_differences, with_value

POSE, JOINTS = "geometry_msgs/msg/PoseStamped", "sensor_msgs/msg/JointState"
GRIPPER, STARTED_OR_STOPPED = "mbd_msgs/msg/WizardGripper", "mbd_msgs/msg/WizardDemonstration"
_START = 1  # WizardDemonstration.START
_ENDINGS = {POSE: "/out/tool_pose", JOINTS: "/out/joint_state", GRIPPER: "wizard/gripper"}


def with_computed_tasks(bag: Bag, session: RecordedSession) -> tuple[RecordedSession, list[StageCheck]]:
    """The session with each task read again off its demonstration, and how it compares with the recorded one.

    Raises:
        MbdError: the recorded parameters cannot be used.
    """
    require_parameters(session, DEMONSTRATION)
    values = DEMONSTRATION.values(recorded_parameters(session.facts, DEMONSTRATION))
    config, joints = demonstration_config(values), values["finger_joints"]
    begins = [
        m.log_time
        for m, msg in bag.decoded({t.name for t in bag.topics if t.msgtype == STARTED_OR_STOPPED})
        if msg.command == _START
    ]
    checks = []
    latest = 0
    for entry in session.tasks:
        before = [b for b in begins if latest < b <= entry.log_time]
        latest = entry.log_time
        if not before:
            why = "corrected afterwards (or repeated by a restarted node), not demonstrated"
            checks.append(StageCheck("task", entry.log_time, (), why))
            continue
        try:
            task = _read_again(bag, entry, before[-1], config, joints)
        except MbdError as error:
            checks.append(StageCheck("task", entry.log_time, (), str(error)))
            continue
        checks.append(StageCheck("task", entry.log_time, task_differences(entry.value, task)))
        session = replace(session, tasks=with_value(session.tasks, entry, task))
    return session, checks


def _read_again(
    bag: Bag, entry: Recorded[Task], begin: int, config: DemonstrationConfig, joints: Sequence[str]
) -> Task:
    """The task that was recorded from ``begin`` [ns of log time] on.

    Settings of versions that read gripper events otherwise (finger_close_at and finger_open_at of 0.1) are not used:
    a difference to the recorded task is reported as every other.
    """
    recording = Recording(entry.value.source, to_seconds(begin), wanted=tuple(joints))
    topics = {t.name for t in bag.topics if t.msgtype in _ENDINGS and t.name.endswith(_ENDINGS[t.msgtype])}
    for message in bag.messages(topics, begin, entry.log_time + 1):
        _add(recording, message, bag.decoder.decode(message))
    return recording.task(entry.value.stamp, config)


def _add(recording: Recording, message: BagMessage, msg: Any) -> None:
    stamp, arrival = to_seconds(header_stamp(message.data)), to_seconds(message.log_time)
    if message.msgtype == POSE:
        p, q = msg.pose.position, msg.pose.orientation
        recording.add_pose(stamp, msg.header.frame_id, (p.x, p.y, p.z), (q.x, q.y, q.z, q.w), arrival)
    elif message.msgtype == GRIPPER:
        if msg.command in tuple(GripperAction):
            recording.add_event(GripperEvent(stamp or to_seconds(message.log_time), GripperAction(msg.command)))
    else:
        recording.add_joints(stamp, msg.name, msg.position, arrival)
