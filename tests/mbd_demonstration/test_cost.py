"""A long demonstration costs little while it is recorded."""

from __future__ import annotations

import time

import numpy as np
import pytest
from mbd_demonstration.finger_joint import FingerJointConfig
from mbd_demonstration.recording import DemonstrationConfig, GripperSource, Recording
from mbd_demonstration.samples import LOOK_RATE, Samples
from mbd_demonstration.synthetic import random_scene

MINUTES, RATE = 10, 1000.0
SCENE = random_scene(np.random.default_rng(0), 4)


@pytest.fixture(scope="module")
def long() -> Recording:
    """Ten minutes at 1 kHz of a hand that closes and opens every 14 s."""
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 60.0 * MINUTES, 1.0 / RATE)
    joint = np.interp(t % 14, [1, 1.5, 3, 3.5, 6, 6.5, 9, 9.5], [0, 1, 1, 0, 0, 0.5, 0.5, 0])
    joint += rng.normal(0.0, 0.005, t.size)
    rows = np.zeros((t.size, 9))
    rows[:, 0] = rows[:, 1] = t
    rows[:, 2:5] = 0.4 + 0.1 * np.sin(t)[:, None] + rng.normal(0.0, 0.001, (t.size, 3))
    rows[:, 8] = 1.0
    recording = Recording(SCENE, 0.0)
    recording.poses.extend(rows)
    recording.fingers["joint_finger_1"] = Samples(3)
    recording.fingers["joint_finger_1"].extend(np.stack([t, t, joint], axis=1))
    return recording


def test_a_look_reads_no_more_samples_than_a_hand_can_show(long: Recording):
    most = LOOK_RATE * 60 * MINUTES * 1.02
    assert len(long.poses) == RATE * 60 * MINUTES
    assert len(long.poses.table(thin=True)) <= most
    assert len(long.fingers["joint_finger_1"].table(thin=True)) <= most


def test_a_look_each_second_at_ten_minutes_of_a_kilohertz_costs_a_tenth_of_a_core(long: Recording):
    config = DemonstrationConfig(GripperSource.JOINT, FingerJointConfig())
    costs = []
    for _ in range(5):
        before = time.process_time()
        long.task(600.0, config, look=True)
        costs.append(time.process_time() - before)
    assert min(costs) <= 0.1  # [s of CPU]: the least of five, as others may use this core's caches


def test_a_look_shows_the_events_of_the_complete_recording(long: Recording):
    config = DemonstrationConfig(GripperSource.JOINT, FingerJointConfig())
    look, complete = (long.task(600.0, config, look=look).problems for look in (True, False))
    assert len(look) == len(complete) > 0
