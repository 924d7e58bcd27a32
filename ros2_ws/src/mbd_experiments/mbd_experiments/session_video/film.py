"""A film of a cell: seen from beside the table by a camera of its own, a caption below, time passing faster."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import mujoco
import numpy as np
from mbd_cell.cell import Cell
from mbd_model.errors import MbdError
from numpy.typing import NDArray
from PIL import Image

WIDTH, HEIGHT, CAPTION = 560, 400, 46  # [px]
LOOK_AT, DISTANCE, AZIMUTH, ELEVATION = (0.36, 0.0, 0.10), 1.30, 205.0, -32.0  # [m], [m], [deg], [deg]
RATE = 10.0  # images a second of film
SKY = 225  # where nothing is, in place of black
COLORS = 96  # of a GIF's palette
LAST_STAYS = 2.5  # [s]


class Film:
    """Takes an image of a cell now and then, and writes them all.

    Args:
        cell: to be filmed, whichever table is laid.
        faster: how many times faster than the cell's time.
        caption: gives the two lines below the image.
    """

    def __init__(self, cell: Cell, faster: float, caption: Callable[[], tuple[str, str]]) -> None:
        self.images: list[NDArray[np.uint8]] = []
        self._cell, self._caption = cell, caption
        self._every = max(1, round(faster / RATE * 100))
        self._ticks = 0
        self._generation = -1
        self._renderer: mujoco.Renderer | None = None
        self._view = mujoco.MjvCamera()
        self._view.lookat[:] = LOOK_AT
        self._view.distance, self._view.azimuth, self._view.elevation = DISTANCE, AZIMUTH, ELEVATION

    def tick(self) -> None:
        """A control tick of the cell has passed."""
        self._ticks += 1
        if self._ticks % self._every == 0:
            self.images.append(self._taken())

    def close(self) -> None:
        """Free the GL context."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _taken(self) -> NDArray[np.uint8]:
        if self._renderer is None or self._generation != self._cell.generation:
            self.close()
            self._renderer = mujoco.Renderer(self._cell.model, HEIGHT, WIDTH)
            self._generation = self._cell.generation
        self._renderer.update_scene(self._cell.simulation.data, camera=self._view)
        page = np.full((HEIGHT + CAPTION, WIDTH, 3), 255, np.uint8)
        image = self._renderer.render()
        page[:HEIGHT] = np.where((image == 0).all(axis=-1, keepdims=True), np.uint8(SKY), image)
        for k, line in enumerate(self._caption()):
            foot = (8, HEIGHT + 18 + 19 * k)
            cv2.putText(page, line, foot, cv2.FONT_HERSHEY_SIMPLEX, 0.43, (0, 0, 0), 1, cv2.LINE_AA)
        return page

    def write(self, path: Path) -> int:
        """Write the film; how many bytes it takes.

        Args:
            path: its suffix says as what: .gif or .mp4.

        Raises:
            MbdError: nothing was filmed, another suffix, or it cannot be written.
        """
        if not self.images:
            raise MbdError("there is nothing to write: the session ended before a single image was taken")
        if path.suffix not in WRITERS:
            raise MbdError(f"a film is written as {' or '.join(WRITERS)}, not as '{path.name}'")
        try:
            WRITERS[path.suffix](path, self.images)
            return path.stat().st_size
        except OSError as error:
            raise MbdError(f"cannot write {path} ({error.strerror or error}); give another place for it") from error


def _write_gif(path: Path, images: list[NDArray[np.uint8]]) -> None:
    # One palette for all, of images from all over the film: what does not change then costs nothing.
    sample = np.concatenate(images[:: max(1, len(images) // 12)], axis=0)
    palette = Image.fromarray(sample).quantize(COLORS, dither=Image.Dither.NONE)
    frames = [Image.fromarray(i).quantize(palette=palette, dither=Image.Dither.NONE) for i in images]
    durations = [round(1000 / RATE)] * (len(frames) - 1) + [round(1000 * LAST_STAYS)]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=True)


def _write_mp4(path: Path, images: list[NDArray[np.uint8]]) -> None:
    height, width = images[0].shape[:2]
    film = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), RATE, (width, height))
    if not film.isOpened():
        raise OSError("this OpenCV has no encoder for it; write a .gif")
    for image in (*images, *[images[-1]] * round(LAST_STAYS * RATE)):
        film.write(image[:, :, ::-1])
    film.release()


WRITERS = {".gif": _write_gif, ".mp4": _write_mp4}
