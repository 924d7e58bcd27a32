"""A recording in a damaged bag is read, or refused in one sentence."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from mbd_bag.repairing.mutations import MUTATIONS, mutate
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import MessageWriter
from mbd_demonstration.files.bag_recording import read_bag
from mbd_demonstration.recording_files import RecordingFileError
from sensor_msgs.msg import JointState


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded") / "bag"
    with BagWriter(folder) as bag:
        writer = MessageWriter(bag)
        for k in range(1, 40):
            pose, joints = PoseStamped(), JointState(name=["finger"], position=[0.01 * k])
            pose.header.stamp.sec = joints.header.stamp.sec = k
            writer.write("/tool_pose", pose, k * 10**9)
            writer.write("/joint_states", joints, k * 10**9)
    return folder


def test_an_intact_one_is_read(recorded: Path):
    read_bag(recorded)


@pytest.mark.parametrize("name", [name for name in MUTATIONS if name != "bomb"])
def test_a_changed_one_is_read_or_refused(name: str, recorded: Path, tmp_path: Path):
    for seed in range(3):
        mutate(recorded, tmp_path / "bag", name, np.random.default_rng(seed))
        try:
            read_bag(tmp_path / "bag")
        except RecordingFileError as error:
            assert "\n" not in str(error)


def test_one_whose_metadata_is_nested_deeply_is_refused(recorded: Path, tmp_path: Path):
    shutil.copytree(recorded, tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").write_text("[" * 500)
    with pytest.raises(RecordingFileError, match="cannot read the bag"):
        read_bag(tmp_path / "bag")
