"""A printed board in MuJoCo, before the cell's camera, with its noise: pictures whose truth is known."""

from __future__ import annotations

from types import TracebackType
from typing import Any

import cv2
import mujoco
import numpy as np
from mbd_cell.physics.camera import COLOR_NOISE, FOVY, INTRINSICS
from mbd_cell.physics.camera_pose import CELL_CAMERA, mujoco_quaternion
from mbd_cell.physics.depth_noise import add_noise
from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.board.printing import board_picture
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.transforms import Transforms, transform
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

LENS = CalibratedLens(INTRINSICS, (), "the cell's camera")
CAMERA = transform(CELL_CAMERA.rotation, CELL_CAMERA.position)
BOARD = PrintedBoard(6, 5, 40.0, 30.0, "4X4_50")
EDGE = 0.012  # [m] of white paper around the squares


class BoardScene:
    """A table, a board that is put anywhere, and the cell's camera. Use as a context manager.

    Args:
        board: what is printed.
    """

    def __init__(self, board: BoardPattern = BOARD) -> None:
        spec = mujoco.MjSpec()
        spec.visual.global_.offwidth, spec.visual.global_.offheight = INTRINSICS.width, INTRINSICS.height
        spec.visual.quality.offsamples = 4
        spec.visual.map.znear, spec.stat.extent = 0.05, 1.0
        spec.visual.headlight.ambient, spec.visual.headlight.diffuse = (0.5, 0.5, 0.5), (0.4, 0.4, 0.4)
        spec.visual.headlight.specular = (0.0, 0.0, 0.0)
        mount = spec.worldbody.add_body(pos=CELL_CAMERA.position, quat=mujoco_quaternion(CELL_CAMERA))
        mount.add_camera(name="camera", fovy=FOVY)
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, pos=(0.6, 0.0, -0.02), size=(0.6, 0.8, 0.02), rgba=(0.6, 0.55, 0.5, 1.0)
        )
        spec.assets = {"print.png": cv2.imencode(".png", board_picture(board))[1].tobytes()}
        spec.add_texture(name="print", type=mujoco.mjtTexture.mjTEXTURE_2D, file="print.png")
        print_ = spec.add_material(name="print")
        print_.textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = "print"
        print_.specular = print_.shininess = 0.0
        w, h = (side / 1000.0 for side in board.size)
        body = spec.worldbody.add_body(name="board", mocap=True)
        # A board's z points into the paper: its face is towards -z.
        spec.add_mesh(
            name="face", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            uservert=[0, 0, 0, w, 0, 0, w, h, 0, 0, h, 0], usertexcoord=[0, 0, 1, 0, 1, 1, 0, 1],
            userface=[0, 2, 1, 0, 3, 2],
        )  # fmt: skip
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname="face", material="print", contype=0, conaffinity=0
        )  # fmt: skip
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, pos=(w / 2, h / 2, 0.0021), size=(w / 2 + EDGE, h / 2 + EDGE, 0.002),
            rgba=(0.95, 0.95, 0.95, 1.0), contype=0, conaffinity=0,
        )  # fmt: skip
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._renderer = mujoco.Renderer(self._model, INTRINSICS.height, INTRINSICS.width)

    def __enter__(self) -> BoardScene:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, tb: TracebackType | None) -> None:
        self._renderer.close()

    def picture(
        self, board2base: Transforms, rng: np.random.Generator | None
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """(H, W, 3) RGB and (H, W) depth [m] with the board there."""
        x, y, z, w = Rotation.from_matrix(board2base[:3, :3]).as_quat()
        self._data.mocap_pos[0], self._data.mocap_quat[0] = board2base[:3, 3], (w, x, y, z)
        mujoco.mj_forward(self._model, self._data)
        self._renderer.update_scene(self._data, camera="camera")
        color: NDArray[Any] = np.array(self._renderer.render())
        self._renderer.enable_depth_rendering()
        depth = np.array(self._renderer.render(), dtype=np.float32)
        self._renderer.disable_depth_rendering()
        if rng is not None:
            depth = add_noise(depth, INTRINSICS.fx, rng)
            color = color + rng.standard_normal((*depth.shape, 1), dtype=np.float32) * COLOR_NOISE
        return np.clip(color, 0, 255).astype(np.uint8), depth
