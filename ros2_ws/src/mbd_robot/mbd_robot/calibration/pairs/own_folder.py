"""A folder of pictures and their tool poses: read, and written picture by picture.

poses.csv        picture,x,y,z,qx,qy,qz,qw (or rx,ry,rz: a rotation vector) [m, rad], or poses.yaml
*.png, *.jpg     the pictures
lens.yaml        camera_calibration's file, or a camera_info (may be missing)
about.yaml       board, mounting, base_frame, camera_frame (may be missing)
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import read_lens
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.taken import PictureFolder, TakenPicture
from mbd_robot.calibration.transforms import Transforms, transform

POSES_CSV, POSES_YAML, LENS, ABOUT = "poses.csv", "poses.yaml", "lens.yaml", "about.yaml"
PLACE, QUATERNION, VECTOR = ("x", "y", "z"), ("qx", "qy", "qz", "qw"), ("rx", "ry", "rz")
COLUMNS = ("picture", *PLACE, *QUATERNION)


def read_own_folder(folder: Path) -> PictureFolder:
    """What lies in a folder; raises CalibrationError for a missing file, and names the line of a bad number."""
    rows = _csv_rows(folder / POSES_CSV) if (folder / POSES_CSV).exists() else _yaml_rows(folder / POSES_YAML)
    pictures = []
    for where, row in rows:
        name = str(row.get("picture", "")).strip()
        if not name:
            raise CalibrationError(f"{where}: no picture is named; expected a column or key 'picture'")
        file = folder / name
        if not file.is_file():
            raise CalibrationError(f"{where}: there is no picture {file}")
        pictures.append(TakenPicture(file, _tool(where, row)))
    if not pictures:
        raise CalibrationError(f"{folder} names no picture; expected one a line of {POSES_CSV}")
    about = _mapping(folder / ABOUT) if (folder / ABOUT).exists() else {}
    lens = read_lens(folder / LENS) if (folder / LENS).exists() else None
    try:
        mounting = BoardMounting(about["mounting"]) if "mounting" in about else None
    except ValueError:
        raise CalibrationError(f"{folder / ABOUT}: mounting '{about['mounting']}'; expected hand or table") from None
    board = board_of(str(about["board"])) if "board" in about else None
    return PictureFolder(
        folder, pictures, lens, mounting, board, str(about.get("base_frame", "")), str(about.get("camera_frame", ""))
    )


def is_own_folder(folder: Path) -> bool:
    """Whether there are poses of ours."""
    return (folder / POSES_CSV).exists() or (folder / POSES_YAML).exists()


def pose_line(picture: str, tool: Transforms) -> str:
    """The line of ``poses.csv`` of a picture and its tool2base (4, 4)."""
    numbers = (*tool[:3, 3], *Rotation.from_matrix(tool[:3, :3]).as_quat())
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow([picture, *(f"{v:.7f}" for v in numbers)])
    return text.getvalue()


def _csv_rows(file: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(f"{file} cannot be read: {error}") from error
    reader = csv.DictReader(io.StringIO(text), skipinitialspace=True)
    for row in reader:
        yield f"{file} line {reader.line_num}", {str(k).strip(): v for k, v in row.items() if k is not None}


def _yaml_rows(file: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    if not file.exists():
        raise CalibrationError(
            f"{file.parent} holds no {POSES_CSV} and no {POSES_YAML}; expected one, with the columns "
            f"{','.join(COLUMNS)}, beside the pictures (or a folder of ada_ros2: N_rgb_img.png, N_sample.npz)"
        )
    try:
        held = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise CalibrationError(f"{file} cannot be read: {error}") from error
    if not isinstance(held, list):
        raise CalibrationError(f"{file} holds no list; expected entries of picture, position, orientation")
    for number, entry in enumerate(held, start=1):
        where = f"{file} entry {number}"
        if not isinstance(entry, Mapping):
            raise CalibrationError(f"{where} is no mapping; expected picture, position, orientation")
        row = dict(entry)
        for names, key in ((PLACE, "position"), (QUATERNION, "orientation")):
            if key in row:
                values = row[key]
                if not isinstance(values, list) or len(values) != len(names):
                    raise CalibrationError(f"{where}: {key} is {values}; expected {len(names)} numbers")
                row.update(zip(names, values, strict=True))
        yield where, row


def _tool(where: str, row: Mapping[str, Any]) -> Transforms:
    turned = VECTOR if VECTOR[0] in row and QUATERNION[0] not in row else QUATERNION
    numbers = []
    for name in (*PLACE, *turned):
        try:
            numbers.append(float(row[name]))
        except KeyError:
            raise CalibrationError(f"{where}: no '{name}'; expected {','.join(COLUMNS)}") from None
        except (TypeError, ValueError):
            raise CalibrationError(f"{where}: {name} is '{row[name]}'; expected a number [m, or of a turn]") from None
    if not np.isfinite(numbers).all():
        raise CalibrationError(f"{where}: a number is not finite; expected a pose in metres")
    if turned is VECTOR:
        return transform(Rotation.from_rotvec(numbers[3:]).as_matrix(), numbers[:3])
    length = float(np.linalg.norm(numbers[3:]))
    if abs(length - 1.0) > 0.05:
        raise CalibrationError(f"{where}: the quaternion has length {length:.2f}; expected 1 (order qx, qy, qz, qw)")
    return transform(Rotation.from_quat(numbers[3:]).as_matrix(), numbers[:3])


def _mapping(file: Path) -> Mapping[str, Any]:
    try:
        held = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise CalibrationError(f"{file} cannot be read: {error}") from error
    if not isinstance(held, Mapping):
        raise CalibrationError(f"{file} holds no keys; expected board, mounting, base_frame, camera_frame")
    return held
