"""Recordings and scenes as files: a trajectory in CSV, the objects on the table in YAML."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene, SceneObject
from numpy.typing import NDArray

from mbd_demonstration.clocks.stamps import checked
from mbd_demonstration.hand.fingers import combined

POSE_COLUMNS = ("t", "x", "y", "z", "qw", "qx", "qy", "qz")
GRIPPER_COLUMN = "gripper"
COLUMNS = (*POSE_COLUMNS, GRIPPER_COLUMN)
# Beyond these no tabletop recording is in the units it should be in.
LONGEST, LONG_SPACING = 3600.0, 0.5  # [s] of a whole recording, where it is so coarse: those of 1 kHz in milliseconds
LONGEST_SPACING, FARTHEST, QUATERNION_SLACK = 5.0, 10.0, 0.1  # [s] between samples, [m] from the base, off length 1


class RecordingFileError(MbdError):
    """A file that cannot be used; the text names the file and the place in it."""


@dataclass(frozen=True)
class RecordedColumns:
    """The columns of a recording, in the order of its rows.

    Attributes:
        stamps: (n,) [s].
        positions: (n, 3) [m, robot base frame].
        quaternions: (n, 4) x, y, z, w.
        gripper: (n,) finger position or opening, in the recording's unit; NaN where the cell is empty.
        notes: what was noticed about stamps and fingers, and what was done about it.
    """

    stamps: NDArray[np.float64]
    positions: NDArray[np.float64]
    quaternions: NDArray[np.float64]
    gripper: NDArray[np.float64]
    notes: tuple[str, ...] = ()


def read_recording(path: Path, fingers: Sequence[str] = (GRIPPER_COLUMN,)) -> RecordedColumns:
    """Read a CSV file with the columns t, x, y, z, qw, qx, qy, qz and the fingers', in any order of columns and rows.

    Args:
        path: of the file; columns it has besides are left alone, empty cells are lost values.
        fingers: the columns of the gripper: one, or one for each finger (see ``fingers.combined``).

    Raises:
        RecordingFileError: the file cannot be read, lacks a column or a row, a cell is no number, or the numbers
            cannot be seconds, metres or a quaternion.
    """
    wanted = (*POSE_COLUMNS, *fingers)
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.DictReader(stream, skipinitialspace=True)
            reader.fieldnames = [name.strip() for name in reader.fieldnames or ()]
            twice = sorted({c for c in wanted if list(reader.fieldnames).count(c) > 1})
            if twice:
                raise RecordingFileError(
                    f"{path} has the columns {twice} more than once: which one to read is not known"
                )
            missing = [c for c in wanted if c not in reader.fieldnames]
            if missing:
                found = reader.fieldnames or "nothing"
                raise RecordingFileError(f"{path} lacks the columns {missing}; its first line names {found}")
            rows = [_numbers(row, wanted, path, reader.line_num) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RecordingFileError(f"cannot read {path}: {error}") from error
    if not rows:
        raise RecordingFileError(f"{path} has no rows below its first line: nothing was recorded")
    table = np.array(rows)
    t, x, y, z, qw, qx, qy, qz = table[:, : len(POSE_COLUMNS)].T
    gripper = table[:, len(POSE_COLUMNS) :]
    columns = recorded_columns(
        t, np.stack([x, y, z], axis=1), np.stack([qx, qy, qz, qw], axis=1), dict(zip(fingers, gripper.T, strict=True))
    )
    check_units(columns, path)
    return columns


def recorded_columns(
    stamps: NDArray[np.float64],
    positions: NDArray[np.float64],
    quaternions: NDArray[np.float64],
    fingers: Mapping[str, NDArray[np.float64]],
) -> RecordedColumns:
    """The columns of any file, its stamps looked at and its fingers made one; shapes as in RecordedColumns."""
    dated = checked(stamps, "the rows")
    gripper = combined(fingers)
    return RecordedColumns(dated.stamps, positions, quaternions, gripper.values, (*dated.notes, *gripper.notes))


def columns_of(
    poses: Mapping[str, NDArray[np.float64]],
    fingers: Mapping[str, NDArray[np.float64]],
    path: Path,
    notes: tuple[str, ...] = (),
) -> RecordedColumns:
    """The columns of a file whose arrays (n,) are named as POSE_COLUMNS; ``notes`` of its reader come first.

    Raises:
        RecordingFileError: numbers that cannot be seconds, metres or a quaternion.
    """
    positions = np.stack([poses[k] for k in ("x", "y", "z")], axis=1)
    quaternions = np.stack([poses[k] for k in ("qx", "qy", "qz", "qw")], axis=1)
    columns = recorded_columns(poses["t"], positions, quaternions, fingers)
    check_units(columns, path, poses=bool(np.isfinite(positions).any()))
    return replace(columns, notes=(*notes, *columns.notes))


def check_units(columns: RecordedColumns, path: Path, *, poses: bool = True) -> None:
    """Raise RecordingFileError where numbers cannot be what their columns should hold; without ``poses`` of times."""
    t = np.unique(columns.stamps[np.isfinite(columns.stamps)])
    if t.size < 2:
        raise RecordingFileError(f"{path} has {t.size} different times in column t; expected rising times in seconds")
    if (spacing := float(np.median(np.diff(t)))) > LONGEST_SPACING:
        raise RecordingFileError(f"{path}: samples are {spacing:g} apart in column t; it must hold seconds")
    lasts = float(t[-1] - t[0])
    if lasts > LONGEST and spacing > LONG_SPACING:
        raise RecordingFileError(
            f"{path} lasts {lasts / 3600.0:.1f} h with {spacing:g} s between samples; column t must hold seconds (are "
            "these milliseconds?)"
        )
    if not np.isfinite(columns.gripper).any():
        raise RecordingFileError(f"{path} has no number in the gripper's columns: what it did is not recorded")
    if not poses:
        return
    positions = columns.positions[np.isfinite(columns.positions).all(axis=1)]
    if not positions.size:
        raise RecordingFileError(f"{path} has no row with numbers for x, y and z: where the tool was is not recorded")
    if (far := float(np.median(np.abs(positions).max(axis=1)))) > FARTHEST:
        raise RecordingFileError(f"{path}: the tool is {far:g} from the robot's base; x, y and z must be in metres")
    norms = np.linalg.norm(columns.quaternions, axis=1)
    norms = norms[np.isfinite(norms) & (norms > 0.0)]
    if norms.size and abs(float(np.median(norms)) - 1.0) > QUATERNION_SLACK:
        raise RecordingFileError(
            f"{path}: qw, qx, qy, qz have length {np.median(norms):.2f}; a quaternion's is 1 (are these Euler angles?)"
        )


def _numbers(row: Mapping[str, str | None], wanted: Sequence[str], path: Path, line: int) -> list[float]:
    try:
        return [float((row[c] or "").strip() or "nan") for c in wanted]
    except ValueError as error:
        raise RecordingFileError(f"{path}, line {line}: {error}; every cell must hold a number") from error


def read_scene(path: Path) -> Scene:
    """Read a source scene: ``objects``, each with ``id``, ``centroid`` and ``size`` [m], and maybe ``yaw`` [rad].

    Raises:
        RecordingFileError: the file cannot be read, is no YAML, or an object lacks something or cannot be.
    """
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RecordingFileError(f"cannot read {path}: {error}") from error
    entries = document.get("objects") if isinstance(document, dict) else None
    if not isinstance(entries, list) or not entries:
        raise RecordingFileError(f"{path}: expected a list 'objects' with at least one object")
    objects = tuple(_object(entry, f"{path}, object {k + 1}") for k, entry in enumerate(entries))
    try:
        return Scene(Role.SOURCE, objects, frame_id=str(document.get("frame_id", "j2n6s300_link_base")))
    except MbdError as error:
        raise RecordingFileError(f"{path}: {error}") from error


def _object(entry: Any, where: str) -> SceneObject:
    if not isinstance(entry, dict) or not {"id", "centroid", "size"} <= entry.keys():
        raise RecordingFileError(f"{where}: expected id, centroid [x, y, z] and size [width, depth, height]: {entry}")
    try:
        x, y, z = map(float, entry["centroid"])
        width, depth, height = map(float, entry["size"])
        yaw = float(entry.get("yaw", 0.0))
        if max(map(abs, (x, y, z, width, depth, height))) > FARTHEST:
            raise RecordingFileError(f"{where}: {entry} is larger or farther than {FARTHEST:g} m; give metres")
        return SceneObject(str(entry["id"]), (x, y, z), (width, depth, height), yaw=yaw)
    except (TypeError, ValueError) as error:
        raise RecordingFileError(f"{where}: {error}") from error
