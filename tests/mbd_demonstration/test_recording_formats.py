"""A demonstration says the same whatever layout it is stored in."""

from __future__ import annotations

import builtins
import importlib
import json
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.files.recording_formats import Selection, read_any
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper
from mbd_demonstration.recording_files import RecordedColumns
from mbd_demonstration.steps_command import run
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_scene
from mbd_model.errors import MbdError
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore


@pytest.fixture(scope="module")
def shown() -> Demonstration:
    scene = random_scene(np.random.default_rng(5), 4)
    recorder = Sensing(polarity=Polarity.LARGER_OPEN, travel=0.08, rate=20.0)
    return demonstrate(scene, (Move("s1", onto="s2"), Move("s3", onto="s1")), recorder, np.random.default_rng(5))


def assert_shows(columns: RecordedColumns, shown: Demonstration) -> None:
    found = read_gripper(columns.stamps, columns.gripper, FingerJointConfig(polarity=Polarity.LARGER_OPEN)).events
    assert [e.action for e in found] == [e.action for e in shown.events]
    assert [e.stamp for e in found] == pytest.approx([e.stamp for e in shown.events], abs=0.15)


def test_npz_by_column_or_by_array(tmp_path: Path, shown: Demonstration):
    x, y, z = shown.positions.T
    qx, qy, qz, qw = shown.quaternions.T
    one, other = tmp_path / "a.npz", tmp_path / "b.npz"
    np.savez(one, t=shown.stamps, x=x, y=y, z=z, qx=qx, qy=qy, qz=qz, qw=qw, gripper=shown.joint)
    np.savez(other, t=shown.stamps, positions=shown.positions, quaternions=shown.quaternions, gripper=shown.joint)
    for path in (one, other):
        columns = read_any(path)
        assert_shows(columns, shown)
        np.testing.assert_array_equal(columns.positions, shown.positions)
    np.savez(one, t=shown.stamps)
    with pytest.raises(MbdError, match=r"lacks the arrays \['x'"):
        read_any(one)


def test_lerobot_parquet_with_and_without_the_tools_pose(tmp_path: Path, shown: Demonstration):
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "data" / "chunk-000" / "file.parquet"
    path.parent.mkdir(parents=True)
    (tmp_path / "meta").mkdir()
    n = shown.stamps.size
    angles = np.random.default_rng(0).normal(size=(n, 5))
    for names, poses in (
        ([f"joint_{k}.pos" for k in range(5)] + ["gripper.pos"], False),
        (["x", "y", "z", "qx", "qy", "qz", "qw", "gripper"], True),
    ):
        state = (
            np.column_stack([shown.positions, shown.quaternions, shown.joint])
            if poses
            else np.column_stack([angles, shown.joint])
        )
        info = {"features": {"observation.state": {"names": names}}}
        (tmp_path / "meta" / "info.json").write_text(json.dumps(info))
        twice = {
            "timestamp": [*shown.stamps, *shown.stamps],
            "observation.state": [*(0 * state).tolist(), *state.tolist()],
            "episode_index": [0] * n + [1] * n,
        }
        parquet.write_table(pyarrow.table(twice), path)
        columns = read_any(path, Selection(episode=1))
        assert_shows(columns, shown)
        assert np.isfinite(columns.positions).all() == poses
        assert "lack a number" not in run([str(path), "--episode", "1"])
        with pytest.raises(MbdError, match="2 episodes; there is no episode 2"):
            read_any(path, Selection(episode=2))
        assert not read_gripper(columns.stamps, read_any(path).gripper).events  # the first one never moved
    scene = tmp_path / "scene.yaml"
    scene.write_text("objects: [{id: a, centroid: [0.5, 0, 0.1], size: [0.1, 0.1, 0.1]}]")


def test_robomimic_hdf5_with_its_mirrored_fingers(tmp_path: Path, shown: Demonstration):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "demo.hdf5"
    even = np.arange(shown.stamps[0], shown.stamps[-1], 0.05)
    with h5py.File(path, "w") as file:
        seen = file.create_group("data/demo_0/obs")
        seen["robot0_eef_pos"] = np.stack([np.interp(even, shown.stamps, c) for c in shown.positions.T], axis=1)
        seen["robot0_eef_quat"] = np.tile([1.0, 0.0, 0.0, 0.0], (even.size, 1))
        width = np.interp(even, shown.stamps, shown.joint)
        seen["robot0_gripper_qpos"] = np.stack([width / 2, -width / 2], axis=1)
    assert_shows(read_any(path), shown)
    with pytest.raises(MbdError, match="there is no number 3"):
        read_any(path, Selection(episode=3))


@pytest.mark.parametrize(("name", "package"), [("a.parquet", "pyarrow"), ("a.hdf5", "h5py")])
def test_a_reader_that_is_not_installed_is_named_with_what_to_do(tmp_path: Path, name: str, package: str, monkeypatch):
    (tmp_path / name).write_bytes(b"")
    real = importlib.import_module

    def without(module: str, *args: object) -> object:
        if module.partition(".")[0] == package:
            raise builtins.ImportError(module)
        return real(module)

    monkeypatch.setattr(importlib, "import_module", without)
    with pytest.raises(MbdError, match=r"requirements/recordings\.txt"):
        read_any(tmp_path / name)


@pytest.mark.parametrize("name", ["a.npz", "a.parquet", "a.hdf5", "a.mcap"])
def test_a_broken_file_of_any_layout_is_named(tmp_path: Path, name: str):
    (tmp_path / name).write_bytes(b"no such thing")
    with pytest.raises(MbdError, match="cannot read"):
        read_any(tmp_path / name)


def test_our_own_bags_are_read(shown: Demonstration):
    bag = Path(__file__).resolve().parents[2] / "bags" / "stacking"
    lines = run([str(bag), "--polarity", "larger_closed"]).splitlines()
    actions = [line.split()[-1] for line in lines if line.endswith(("open", "close"))]
    assert actions and actions == ["close", "open"] * (len(actions) // 2)


def written(folder: Path, stamps: np.ndarray, arrivals: np.ndarray, shown: Demonstration) -> Path:
    """A bag of a demonstration whose messages are stamped so [s] and were recorded then [s]."""
    store = get_typestore(Stores.ROS2_JAZZY)
    kinds = store.types
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        pose = bag.add_connection("/tool_pose", "geometry_msgs/msg/PoseStamped", typestore=store)
        joint = bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        rows = zip(stamps, arrivals, shown.positions, shown.quaternions, shown.joint, strict=True)
        for stamp, arrived, position, quaternion, finger in rows:
            time = kinds["builtin_interfaces/msg/Time"](int(stamp), int(stamp % 1.0 * 1e9))
            header = kinds["std_msgs/msg/Header"](time, "base")
            where = kinds["geometry_msgs/msg/Pose"](
                kinds["geometry_msgs/msg/Point"](*map(float, position)),
                kinds["geometry_msgs/msg/Quaternion"](*map(float, quaternion)),
            )
            state = kinds["sensor_msgs/msg/JointState"](
                header, ["arm_finger_1"], np.array([finger]), np.zeros(0), np.zeros(0)
            )
            for connection, message in (
                (pose, kinds["geometry_msgs/msg/PoseStamped"](header, where)),
                (joint, state),
            ):
                bag.write(connection, int(arrived * 1e9), store.serialize_cdr(message, connection.msgtype))
    return folder


@pytest.mark.parametrize("back", [0.5, 8.0, 1.7e9])
def test_a_clock_that_goes_back_amid_a_bag_changes_no_step_and_is_named(
    tmp_path: Path, shown: Demonstration, back: float
):
    stamps = shown.stamps - shown.stamps[0] + 1.8e9
    jumped = np.where(np.arange(stamps.size) < stamps.size // 2, stamps, stamps - back)
    plain = run([str(written(tmp_path / "plain", stamps, stamps, shown))]).splitlines()
    after = run([str(written(tmp_path / "after", jumped, stamps, shown))]).splitlines()
    said = [line for line in after if "went back by" in line]
    assert len(said) == 2 and all(f"went back by {back:.3g} s" in line for line in said)
    kept = [line for line in after if line not in said]
    assert [line.split()[-1] for line in kept] == [line.split()[-1] for line in plain]
    times = [[float(line.split()[0]) for line in lines[1:]] for lines in (kept, plain)]
    assert times[0] == pytest.approx(times[1], abs=0.2)


def test_a_plot_is_drawn_with_and_without_steps(tmp_path: Path, shown: Demonstration):
    path, scene = tmp_path / "a.npz", tmp_path / "scene.yaml"
    np.savez(path, t=shown.stamps, positions=shown.positions, quaternions=shown.quaternions, gripper=shown.joint)
    objects = [
        f"  - {{id: {o.object_id}, centroid: {list(o.centroid)}, size: {list(o.size)}, yaw: {o.yaw}}}"
        for o in shown.scene.objects
    ]
    scene.write_text("\n".join(["objects:", *objects]))
    sizes = []
    for options in ([], ["--scene", str(scene)]):
        picture = tmp_path / f"{len(options)}.png"
        run([str(path), "--plot", str(picture), *options])
        assert picture.read_bytes().startswith(b"\x89PNG")
        sizes.append(picture.stat().st_size)
    assert sizes[0] != sizes[1]  # the steps are in the second
