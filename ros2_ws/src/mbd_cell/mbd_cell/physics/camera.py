"""The RGB-D camera: rendered colour and depth, and the cloud they make."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import TracebackType

import mujoco
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_cell.physics.cell_model import CAMERA, HEIGHT, WIDTH
from mbd_cell.physics.depth_noise import add_noise
from mbd_cell.physics.simulation import Simulation

FOVY = 45.0  # [deg]
MAX_DEPTH = 3.5  # farther than this nothing returns [m]
COLOR_NOISE = 2.0  # standard deviation [levels of 255]


_FOCAL = HEIGHT / 2 / math.tan(math.radians(FOVY) / 2)  # [px]
INTRINSICS = Intrinsics(_FOCAL, _FOCAL, (WIDTH - 1) / 2, (HEIGHT - 1) / 2, width=WIDTH, height=HEIGHT)


@dataclass(frozen=True)
class Frame:
    """One image pair.

    Attributes:
        color: (H, W, 3) uint8 RGB.
        depth: (H, W) float32 along the optical axis [m], 0 = no return.
    """

    color: NDArray[np.uint8]
    depth: NDArray[np.float32]

    @property
    def depth_mm(self) -> NDArray[np.uint16]:
        """(H, W) uint16 [mm], 0 = no return."""
        return np.round(self.depth * 1000.0).astype(np.uint16)

    @property
    def points(self) -> NDArray[np.float32]:
        """(H, W, 3) in the optical frame (x right, y down, z forward) [m], NaN = no return."""
        z = np.where(self.depth > 0, self.depth, np.float32(np.nan))
        u, v = INTRINSICS.rays()
        return np.stack((z * u, z * v, z), axis=-1)


class Camera:
    """Renders one model. Use as a context manager, from one thread only (it owns a GL context)."""

    def __init__(self, model: mujoco.MjModel) -> None:
        try:
            self._renderer = mujoco.Renderer(model, HEIGHT, WIDTH)
        except (mujoco.FatalError, RuntimeError, ImportError, AttributeError) as error:
            raise MbdError(
                f"cannot render ({error}); set MUJOCO_GL to osmesa or egl and install libosmesa6 or libegl1"
            ) from error

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Free the GL context."""
        self._renderer.close()

    def render(self, simulation: Simulation, rng: np.random.Generator | None) -> Frame:
        """The image of this state.

        Args:
            simulation: of the model this camera was made for.
            rng: gives the noise; None for perfect images.
        """
        self._renderer.update_scene(simulation.data, camera=CAMERA)
        color = np.array(self._renderer.render())
        self._renderer.enable_depth_rendering()
        try:
            depth = np.array(self._renderer.render(), dtype=np.float32)
        finally:
            self._renderer.disable_depth_rendering()
        depth[depth > MAX_DEPTH] = 0.0
        if rng is not None:
            depth = add_noise(depth, INTRINSICS.fx, rng)
            grain = rng.standard_normal((HEIGHT, WIDTH, 1), dtype=np.float32) * np.float32(COLOR_NOISE)
            color = np.clip(color.astype(np.float32) + grain, 0, 255).astype(np.uint8)
        return Frame(color, depth)
