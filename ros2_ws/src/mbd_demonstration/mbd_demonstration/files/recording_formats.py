"""Recordings of other layouts than CSV: NPZ, rosbags, LeRobot's parquet and robomimic's HDF5, as the same columns."""

from __future__ import annotations

import importlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbd_demonstration.files.bag_recording import read_bag
from mbd_demonstration.hand.fingers import named_fingers
from mbd_demonstration.recording_files import (
    GRIPPER_COLUMN,
    POSE_COLUMNS,
    RecordedColumns,
    RecordingFileError,
    columns_of,
    read_recording,
)

Floats = NDArray[np.float64]
# robomimic keeps no stamps; its robots are commanded so often [Hz].
ROBOMIMIC_RATE = 20.0
# Endings of files that can hold several recordings.
EPISODES = (".parquet", ".hdf5", ".h5")


@dataclass(frozen=True)
class Selection:
    """What to read of a file that holds more than one recording, or no stamps.

    Attributes:
        fingers: columns (CSV, NPZ), joints (bags) or names in a state vector; empty: found by their names.
        episode: which recording of the file, 0-based.
        rate: [Hz] of a layout without stamps.
    """

    fingers: tuple[str, ...] = ()
    episode: int = 0
    rate: float = ROBOMIMIC_RATE


def read_any(path: Path, reading: Selection | None = None) -> RecordedColumns:
    """Read a recording of any layout, told by the name's ending; a folder or .mcap is a rosbag.

    A layout without tool poses gives columns whose positions are NaN: its gripper events can be read, no steps.

    Raises:
        RecordingFileError: it cannot be read, the layout is another, or a package that reads it is not installed.
    """
    reading = reading or Selection()
    ending = path.suffix.lower()
    if reading.episode and ending not in EPISODES:
        raise RecordingFileError(
            f"--episode is {reading.episode}, and {path} holds one recording; several are in LeRobot's .parquet and "
            "robomimic's .hdf5 only"
        )
    if path.is_dir() or ending in (".mcap", ".db3"):
        return read_bag(path, reading.fingers)
    if ending == ".npz":
        return _npz(path, reading)
    if ending == ".parquet":
        return _lerobot(path, reading)
    if ending in (".hdf5", ".h5"):
        return _robomimic(path, reading)
    return read_recording(path, reading.fingers or (GRIPPER_COLUMN,))


def episodes_of(path: Path) -> int:
    """How many recordings a file holds: one, but in LeRobot's and robomimic's layouts.

    Raises:
        RecordingFileError: it cannot be read.
    """
    ending = path.suffix.lower()
    if not path.exists():
        raise RecordingFileError(f"{path} does not exist; expected a recording, or a folder with traj.csv")
    try:
        if ending == ".parquet":
            columns = _required("pyarrow.parquet", path).read_table(path)
            return int(np.unique(columns["episode_index"]).size) if "episode_index" in columns.schema.names else 1
        if ending in (".hdf5", ".h5"):
            with _required("h5py", path).File(path, "r") as file:
                return len(file["data"])
    except (OSError, ValueError, KeyError) as error:
        raise RecordingFileError(f"cannot read {path}: {error}") from error
    return 1


def _npz(path: Path, reading: Selection) -> RecordedColumns:
    """Arrays named as the CSV's columns; or positions (n, 3) [m] and quaternions (n, 4) x, y, z, w beside t."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: np.asarray(stored[name], dtype=float) for name in stored.files}
    except (OSError, ValueError) as error:
        raise RecordingFileError(f"cannot read {path}: {error}") from error
    fingers = reading.fingers or (GRIPPER_COLUMN,)
    if {"positions", "quaternions"} <= arrays.keys():
        arrays |= dict(zip("xyz", arrays["positions"].T, strict=False))
        arrays |= dict(zip(("qx", "qy", "qz", "qw"), arrays["quaternions"].T, strict=False))
    missing = [name for name in (*POSE_COLUMNS, *fingers) if name not in arrays]
    if missing:
        raise RecordingFileError(f"{path} lacks the arrays {missing}; it has {sorted(arrays)}")
    used = {name: arrays[name] for name in (*POSE_COLUMNS, *fingers)}
    if len({a.shape for a in used.values()}) != 1 or used["t"].ndim != 1:
        shapes = {name: a.shape for name, a in used.items()}
        raise RecordingFileError(f"{path}: arrays of shapes {shapes}; expected (n,) for each, the same n")
    if not used["t"].size:
        raise RecordingFileError(f"{path} has arrays without a value: nothing was recorded")
    return columns_of(used, {name: used[name] for name in fingers}, path)


def _without_poses(stamps: Floats, fingers: dict[str, Floats], path: Path) -> RecordedColumns:
    lost = np.full(stamps.size, np.nan)
    return columns_of({"t": stamps, **dict.fromkeys(("x", "y", "z", "qx", "qy", "qz", "qw"), lost)}, fingers, path)


def _required(module: str, path: Path) -> Any:
    """A package that only this layout needs."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise RecordingFileError(
            f"{path} is read by {package}, which is not installed: pip install -r requirements/recordings.txt"
        ) from error


def _lerobot(path: Path, reading: Selection) -> RecordedColumns:
    """One episode of a LeRobot dataset: timestamp [s] and observation.state (or state), named in meta/info.json.

    A state with x, y, z and qx, qy, qz, qw holds the tool's pose; one of joint angles only gives gripper events.
    """
    parquet = _required("pyarrow.parquet", path)
    try:
        table = parquet.read_table(path).to_pydict()
    except (OSError, ValueError) as error:  # what pyarrow raises are kinds of both
        raise RecordingFileError(f"cannot read {path}: {error}") from error
    column = "state" if "state" in table else "observation.state"
    missing = [name for name in ("timestamp", column) if name not in table]
    if missing:
        raise RecordingFileError(f"{path} lacks the columns {missing} of a LeRobot dataset; it has {sorted(table)}")
    episodes = np.array(table.get("episode_index", [0] * len(table["timestamp"])))
    known = np.unique(episodes)
    if not 0 <= reading.episode < known.size:
        raise RecordingFileError(f"{path} has {known.size} episodes; there is no episode {reading.episode} (from 0)")
    chosen = episodes == known[reading.episode]
    state = np.array(table[column], dtype=float)[chosen]
    stamps = np.array(table["timestamp"], dtype=float)[chosen].ravel()
    names = _state_names(path, column, state.shape[1])
    used = named_fingers(names, reading.fingers)
    if not used:
        raise RecordingFileError(
            f"{path}: none of the state's numbers {names} is named as a gripper's; give its name with --fingers"
        )
    fingers = {name: state[:, names.index(name)] for name in used}
    short = {name.rpartition(".")[2]: k for k, name in enumerate(names)}
    if not set(POSE_COLUMNS[1:]) <= short.keys():
        return _without_poses(stamps, fingers, path)
    poses = {name: state[:, short[name]] for name in POSE_COLUMNS[1:]}
    return columns_of({"t": stamps, **poses}, fingers, path)


def _state_names(path: Path, column: str, width: int) -> tuple[str, ...]:
    """Names of the state's numbers, from the dataset's meta/info.json; numbered, the last the gripper, without it."""
    for folder in path.resolve().parents:
        info = folder / "meta" / "info.json"
        if not info.is_file():
            continue
        try:
            names = json.loads(info.read_text(encoding="utf-8"))["features"][column]["names"]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise RecordingFileError(f"cannot read the names of the state from {info}: {error!r}") from error
        if isinstance(names, dict):
            names = [name for group in names.values() for name in group]
        if names and len(names) == width:
            return tuple(map(str, names))
    return (*(f"state_{k}" for k in range(width - 1)), "gripper")


def _robomimic(path: Path, reading: Selection) -> RecordedColumns:
    """One demonstration of robomimic's HDF5: robot0_eef_pos, robot0_eef_quat (x, y, z, w), robot0_gripper_qpos."""
    h5py = _required("h5py", path)
    try:
        with h5py.File(path, "r") as file:
            demos = sorted(file["data"], key=lambda name: (len(name), name))
            if not 0 <= reading.episode < len(demos):
                raise RecordingFileError(
                    f"{path} has {len(demos)} demonstrations; there is no number {reading.episode} (from 0)"
                )
            seen = file["data"][demos[reading.episode]]["obs"]
            position, quaternion, qpos = (
                np.array(seen[f"robot0_{name}"], dtype=float) for name in ("eef_pos", "eef_quat", "gripper_qpos")
            )
    except (OSError, KeyError) as error:
        raise RecordingFileError(
            f"cannot read {path}: {error}; expected robomimic's data/demo_*/obs/robot0_eef_pos, _eef_quat "
            "and _gripper_qpos"
        ) from error
    qpos = qpos.reshape(len(position), -1)
    poses = dict(zip(("x", "y", "z"), position.T, strict=True)) | dict(
        zip(("qx", "qy", "qz", "qw"), quaternion.T, strict=True)
    )
    fingers = {f"finger_{k + 1}": column for k, column in enumerate(qpos.T)}
    return columns_of({"t": np.arange(len(position)) / reading.rate, **poses}, fingers, path)
