"""What is printed on synthetic objects: stripes, bands, labels, the many colours of a cereal box."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[int, int, int]


class Pattern(Enum):
    """How colours follow each other on a surface."""

    STRIPES = "upright stripes round the object"
    BANDS = "level bands round the object"
    LABEL = "a label in the middle of every face, with lines of text"
    PRINT = "fields, discs and lines of text, different on every face"
    FACES = "every face of another colour"


@dataclass(frozen=True)
class Paint:
    """The print of one object.

    Attributes:
        pattern: its kind.
        colors: RGB; the object's own colour is the ground they are printed on.
        seed: of what is random about it.
    """

    pattern: Pattern
    colors: tuple[Rgb, ...]
    seed: int = 0

    def over(self, ground: Rgb, points: NDArray[np.float64], size: tuple[float, float, float]) -> NDArray[np.float64]:
        """(n, 3) RGB of the surface at (n, 3) points [m, own frame, origin at the middle of the foot], sides [m]."""
        palette: NDArray[np.float64] = np.array([ground, *self.colors], dtype=np.float64)
        half = 0.5 * np.asarray(size)
        scaled = (points - np.array([0.0, 0.0, half[2]])) / half  # -1..1 along each axis
        axis = np.abs(scaled).argmax(axis=1)
        face = 2 * axis + (scaled[np.arange(len(scaled)), axis] > 0)
        if self.pattern is Pattern.FACES:
            index = face % len(palette)
        elif self.pattern is Pattern.BANDS:
            index = np.floor((scaled[:, 2] + 1) * 2.5).astype(int) % len(palette)
        elif self.pattern is Pattern.STRIPES:
            index = np.floor((scaled[:, 0] - scaled[:, 1] + 2) * 2.5).astype(int) % len(palette)
        elif self.pattern is Pattern.LABEL:
            index = _labelled(*_on_face(scaled, face), len(palette))
        else:
            index = _printed(*_on_face(scaled, face), face, len(palette), self.seed)
        painted: NDArray[np.float64] = palette[index]
        return painted


def _labelled(across: NDArray[np.float64], along: NDArray[np.float64], colors: int) -> NDArray[np.int_]:
    """Which colour, by number: a label with lines of text in the last colour."""
    index = np.zeros(len(across), dtype=int)
    index[(np.abs(across) < 0.7) & (np.abs(along) < 0.5)] = 1
    index[(np.abs(across) < 0.5) & (np.abs(along) < 0.4) & (np.floor(along * 20) % 2 == 0)] = colors - 1
    return index


def _on_face(scaled: NDArray[np.float64], face: NDArray[np.int_]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two coordinates, -1..1, on the face that each point lies on."""
    axis = face // 2
    across = np.where(axis == 0, scaled[:, 1], scaled[:, 0])
    along = np.where(axis == 2, scaled[:, 1], scaled[:, 2])
    return across, along


def _printed(
    across: NDArray[np.float64], along: NDArray[np.float64], face: NDArray[np.int_], colors: int, seed: int
) -> NDArray[np.int_]:
    """Which colour, by number: on each face a field, a disc, a strip and lines of text at random places."""
    index = np.zeros(len(across), dtype=int)
    for number in range(6):
        on = face == number
        rng = np.random.default_rng([seed, number])
        field, strip, disc, text = rng.integers(0, colors, 4)
        edge = rng.uniform(-0.6, 0.6)
        upright = rng.random() < 0.5
        index[on & ((across if upright else along) < edge)] = field
        x, y, radius = rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(0.2, 0.6)
        index[on & (np.hypot(across - x, along - y) < radius)] = disc
        low = rng.uniform(-0.9, 0.6)
        index[on & (along > low) & (along < low + 0.25)] = strip
        lines = (np.abs(across - x) < 0.6) & (np.abs(along + y) < 0.3) & (np.floor(along * 24) % 2 == 0)
        index[on & lines] = text
    return index
