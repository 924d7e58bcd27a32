"""Recordings and scenes as files: a trajectory in CSV, the objects on the table in YAML."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene, SceneObject
from numpy.typing import NDArray

COLUMNS = ("t", "x", "y", "z", "qw", "qx", "qy", "qz", "gripper")


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
    """

    stamps: NDArray[np.float64]
    positions: NDArray[np.float64]
    quaternions: NDArray[np.float64]
    gripper: NDArray[np.float64]


def read_recording(path: Path) -> RecordedColumns:
    """Read a CSV file with the columns t, x, y, z, qw, qx, qy, qz, gripper, in any order; others are left alone.

    Raises:
        RecordingFileError: the file cannot be read, lacks a column or a row, or a cell is no number.
    """
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream)
            missing = [c for c in COLUMNS if c not in (reader.fieldnames or ())]
            if missing:
                found = reader.fieldnames or "nothing"
                raise RecordingFileError(f"{path} lacks the columns {missing}; its first line names {found}")
            rows = [_numbers(row, path, reader.line_num) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RecordingFileError(f"cannot read {path}: {error}") from error
    if not rows:
        raise RecordingFileError(f"{path} has no rows below its first line: nothing was recorded")
    t, x, y, z, qw, qx, qy, qz, gripper = np.array(rows).T
    return RecordedColumns(t, np.stack([x, y, z], axis=1), np.stack([qx, qy, qz, qw], axis=1), gripper)


def _numbers(row: Mapping[str, str | None], path: Path, line: int) -> list[float]:
    try:
        return [float(row[c] or "nan") for c in COLUMNS]
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
        return SceneObject(str(entry["id"]), (x, y, z), (width, depth, height), yaw=yaw)
    except (TypeError, ValueError) as error:
        raise RecordingFileError(f"{where}: {error}") from error
