"""What a failed trial leaves behind: a picture of the table before and after the robot's work, and what went wrong."""

from __future__ import annotations

import textwrap
from pathlib import Path

import cv2
import mujoco
import numpy as np
from mbd_cell.cell import Cell
from mbd_cell.physics.camera import Camera
from mbd_model.errors import MbdError
from numpy.typing import NDArray

LINE, MARGIN = 22, 8  # [px]
CHARACTERS = 130  # of a line of text


def photograph(cell: Cell) -> NDArray[np.uint8]:
    """(H, W, 3) RGB: the table as it is, without the camera's noise and with the arm out of view."""
    physics = cell.simulation
    before = physics.data.qpos.copy()
    for name, angle in zip(cell.robot.arm_joints, cell.robot.arm.tucked, strict=True):
        physics.data.qpos[physics.model.joint(name).qposadr[0]] = angle
    mujoco.mj_kinematics(physics.model, physics.data)
    with Camera(cell.model) as camera:
        color = camera.render(physics, None).color
    physics.data.qpos[:] = before
    mujoco.mj_forward(physics.model, physics.data)
    return color


def write_picture(path: Path, before: NDArray[np.uint8], after: NDArray[np.uint8], text: str) -> None:
    """Write both images side by side with a text below.

    Args:
        path: of the PNG.
        before: (H, W, 3) RGB when the robot began.
        after: (H, W, 3) RGB at the end.
        text: what went wrong.

    Raises:
        MbdError: it cannot be written.
    """
    lines = [line for part in text.splitlines() for line in textwrap.wrap(part, CHARACTERS)]
    images = np.concatenate((before, after), axis=1)
    page = np.full((images.shape[0] + LINE * len(lines) + 2 * MARGIN, images.shape[1], 3), 255, np.uint8)
    page[: images.shape[0]] = images
    for k, line in enumerate(lines):
        foot = (MARGIN, images.shape[0] + LINE * (k + 1))
        cv2.putText(page, line, foot, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
    if not cv2.imwrite(str(path), page[:, :, ::-1]):
        raise MbdError(f"cannot write the picture {path}; give a folder that can be written to")
