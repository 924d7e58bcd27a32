"""The file of parameters that tells a session where its camera stands."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import numpy as np
import yaml
from mbd_model.camera.parameters import CAMERA_ORIENTATION, CAMERA_POSITION, camera_pose
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.transforms import Transforms

WIDTH = 118


def write_camera_file(
    file: Path, camera2base: Transforms, frames: tuple[str, str], notes: Sequence[str], when: datetime
) -> None:
    """Write parameters ``camera_position`` and ``camera_orientation`` for perception and console.

    Args:
        file: to write.
        camera2base: (4, 4) [m].
        frames: (base frame, optical frame), for people; "" for unknown.
        notes: what is known of it, a comment each.
        when: it was found.

    Raises:
        MbdError: the file is there already, or cannot be written.
    """
    base, optical = (name or "?" for name in frames)
    comments = [
        f"Where the camera stands, by `calibrate` on {when:%Y-%m-%d %H:%M}. For a session: camera_file:=THIS FILE",
        f"The pose is that of {optical} (x right, y down, z forward) in {base}; m and (x, y, z, w).",
        *notes,
    ]
    position = [float(round(v, 6)) for v in camera2base[:3, 3]]
    quaternion = [float(round(v, 8)) for v in Rotation.from_matrix(camera2base[:3, :3]).as_quat()]
    lines = [line for comment in comments for line in _comment(comment)]
    lines += ["/**:", "  ros__parameters:"]
    lines += [f"    {CAMERA_POSITION.name}: {position}", f"    {CAMERA_ORIENTATION.name}: {quaternion}"]
    write_new(file, "\n".join(lines) + "\n")


def write_new(file: Path, text: str) -> None:
    """Write a file that is not there yet; raises MbdError when it is, or cannot be written."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("x", encoding="utf-8") as out:
            out.write(text)
    except FileExistsError:
        raise MbdError(f"{file} is there already, and nothing is overwritten; give another name") from None
    except OSError as error:
        raise MbdError(f"{file} cannot be written: {error.strerror}; give another place") from error


def read_camera_file(file: Path) -> CameraPose:
    """The pose in such a file; raises MbdError as ``read_camera_parameters``."""
    return camera_pose(read_camera_parameters(file))


def read_camera_parameters(file: Path) -> dict[str, list[float]]:
    """The parameters in such a file, by name.

    Raises:
        MbdError: no such file, or it lacks a parameter, or holds no pose; says which.
    """
    try:
        held = yaml.safe_load(file.read_text(encoding="utf-8"))
        values = {}
        for node in held.values():
            values.update(node["ros__parameters"])
        names = (CAMERA_POSITION.name, CAMERA_ORIENTATION.name)
        parameters = {name: [float(v) for v in values[name]] for name in names}
    except (OSError, UnicodeDecodeError) as error:
        raise MbdError(f"the camera file {file} cannot be read: {error}") from error
    except (yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise MbdError(
            f"{file} is no camera file ({error}); expected ros__parameters with camera_position and "
            "camera_orientation, as `calibrate` writes it"
        ) from error
    camera_pose(parameters)
    return parameters


def pose_matrix(pose: CameraPose) -> Transforms:
    """(4, 4) camera2base."""
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = pose.rotation, pose.position
    return made


def _comment(text: str) -> list[str]:
    lines, line = [], "#"
    for word in text.split():
        if len(line) + 1 + len(word) > WIDTH:
            lines.append(line)
            line = "#  "
        line += f" {word}"
    return [*lines, line]
