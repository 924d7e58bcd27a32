"""A session's task once more, from the tool's path and the gripper: the stage between scenes and assists."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from mbd_bag.recorder.thinning import header_stamp
from mbd_bag.session.recorded_session import Recorded, RecordedSession
from mbd_bag.session.session_facts import parameters_of
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.mcap_file import BagMessage
from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.recording import DemonstrationConfig, GripperSource, Recording
from mbd_model.errors import MbdError
from mbd_model.task import Task

from mbd_study.recompute.stages import StageCheck, task_differences, with_value

POSE, JOINTS = "geometry_msgs/msg/PoseStamped", "sensor_msgs/msg/JointState"
GRIPPER, DEMONSTRATION = "mbd_msgs/msg/WizardGripper", "mbd_msgs/msg/WizardDemonstration"
_START = 1  # WizardDemonstration.START
_ENDINGS = {POSE: "/out/tool_pose", JOINTS: "/out/joint_state", GRIPPER: "wizard/gripper"}
JACO_FINGERS = [f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)]


def demonstration_config(parameters: dict[str, Any]) -> tuple[DemonstrationConfig, list[str]]:
    """The demonstration node's config and finger joints, as recorded; raises MbdError for values of no use."""
    geometry = {f.name: parameters[f.name] for f in fields(StepSegmentationConfig) if f.name in parameters}
    finger = {
        f.name: parameters[f"finger_{f.name}"] for f in fields(FingerJointConfig) if f"finger_{f.name}" in parameters
    }
    if "polarity" in finger:
        finger["polarity"] = Polarity(finger["polarity"])
    source = GripperSource(parameters.get("gripper_source", GripperSource.SPOKEN))
    config = DemonstrationConfig(source, FingerJointConfig(**finger), StepSegmentationConfig(**geometry))
    return config, list(parameters.get("finger_joints", JACO_FINGERS))


def with_computed_tasks(bag: Bag, session: RecordedSession) -> tuple[RecordedSession, list[StageCheck]]:
    """The session with each task read again off its demonstration, and how it compares with the recorded one.

    Raises:
        MbdError: the recorded parameters cannot be used.
    """
    config, joints = demonstration_config(parameters_of(session.facts, "demonstration"))
    begins = [
        m.log_time
        for m, msg in bag.decoded({t.name for t in bag.topics if t.msgtype == DEMONSTRATION})
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


def _read_again(bag: Bag, entry: Recorded[Task], begin: int, config: DemonstrationConfig, joints: list[str]) -> Task:
    """The task that was recorded from ``begin`` [ns of log time] on."""
    recording = Recording(entry.value.source, begin / 1e9)
    topics = {t.name for t in bag.topics if t.msgtype in _ENDINGS and t.name.endswith(_ENDINGS[t.msgtype])}
    for message in bag.messages(topics, begin, entry.log_time + 1):
        _add(recording, message, bag.decoder.decode(message), joints)
    return recording.task(entry.value.stamp, config)


def _add(recording: Recording, message: BagMessage, msg: Any, joints: list[str]) -> None:
    stamp = header_stamp(message.data) / 1e9
    if message.msgtype == POSE:
        p, q = msg.pose.position, msg.pose.orientation
        recording.add_pose(stamp, msg.header.frame_id, (p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
    elif message.msgtype == GRIPPER:
        if msg.command in tuple(GripperAction):
            recording.add_event(GripperEvent(stamp or message.log_time / 1e9, GripperAction(msg.command)))
    else:
        at = [float(msg.position[msg.name.index(j)]) for j in joints if j in msg.name]
        if len(at) == len(joints):
            recording.add_finger(stamp, sum(at) / len(at))
