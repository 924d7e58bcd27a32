"""The demonstration node reads the finger joints, whatever the hand, as the tool reads files."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from demonstration_session import BEGIN, Session, steps_of
from mbd_demonstration.finger_joint import read_gripper
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_demonstration.understanding import understood
from mbd_model.ros.conversions import time_from_msg
from mbd_model.ros.qos import LATCHED
from mbd_msgs.msg import Task
from sensor_msgs.msg import JointState


def test_the_finger_joint_gives_the_demonstrated_steps(ros_domain: int, tmp_path: Path, shown: Demonstration):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    assert session.ask("stop").success
    session.until(lambda: len(session.tasks) > 0)
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    session.close()


def test_a_node_reads_off_the_joint_what_the_files_tool_reads(ros_domain: int, tmp_path: Path):
    """Live and from files: the same samples, as noisy as they come, give the same steps and the same problems."""
    rng = np.random.default_rng(8)
    scene = random_scene(rng, 4)
    recorder = Sensing(rate=15.0, dropout=0.1, shuffle=0.2, joint_std=0.02, half_closings=1, ramp=0.8)
    shown = demonstrate(scene, (Move("s1", onto="s2"), Move("s3", onto="s4")), recorder, rng, begin=BEGIN)
    begins_closed = shown.stamps > shown.events[0].stamp + 1.0
    received = dataclasses.replace(
        shown, **{k: getattr(shown, k)[begins_closed] for k in ("stamps", "positions", "quaternions", "joint")}
    )
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.observe(shown)
    session.ask("start")
    session.play(received, words=False)
    answer = session.ask("stop")
    session.until(lambda: len(session.tasks) > 0)
    session.close()
    path = ToolTrajectory.from_samples(received.stamps, received.positions, received.quaternions)
    offline = understood(path, read_gripper(received.stamps, received.joint), scene, stamp=0.0)
    assert steps_of(session.tasks[-1]) == [(int(s.kind), s.primary_object) for s in offline.steps]
    assert list(session.tasks[-1].problems) == list(offline.problems)
    assert "began with the gripper closed" in answer.message
    ends = [time_from_msg(s.end) for s in session.tasks[-1].steps]
    assert ends == pytest.approx([s.end for s in offline.steps], abs=1e-6)


def test_steps_read_off_the_joint_are_shown_while_it_runs(ros_domain: int, tmp_path: Path, shown: Demonstration):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    recorded: list[Task] = []
    session.peer.create_subscription(Task, "demonstration/recorded", recorded.append, LATCHED)
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    session.until(lambda: bool(recorded) and len(recorded[-1].steps) == len(shown.steps))
    session.ask("start")
    session.until(lambda: len(recorded[-1].steps) == 0)
    session.close()


def test_joint_states_with_names_and_no_positions_are_left_out_and_counted(
    ros_domain: int, tmp_path: Path, shown: Demonstration
):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.observe(shown)
    session.ask("start")
    empty = JointState(name=[f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)])
    while session.node.recording.empty == 0:
        session.joints.publish(empty)
        session.executor.spin_once(timeout_sec=0.02)
    session.play(shown, words=False)
    session.ask("stop")
    session.until(lambda: len(session.tasks) > 0)
    session.close()
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    assert any("names and no positions" in problem for problem in session.tasks[-1].problems)


def test_fingers_of_another_hand_are_found_by_their_names(ros_domain: int, tmp_path: Path, shown: Demonstration):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.names = ["arm_joint_1", "robotiq_85_left_knuckle_joint"]
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    session.ask("stop")
    session.until(lambda: len(session.tasks) > 0)
    session.close()
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
