"""Seams: where two plain things of different colours stand flush, depth shows one surface, and only colour two.

A label, a picture, a stripe are borders of colours too, and one thing in pieces is worse than two things in one. So a
border of colours counts as a seam only when it is what flush boxes show and print hardly does: both sides are of one
plain colour each, each in one piece; the border lies in one upright or level plane, that in which they touch; it runs
straight over two faces that meet at a right angle; and both sides are thick, seen across that plane: a face of another
colour is not.

Colours are compared by chromaticity (r, g of R + G + B = 1), which neither shading nor shadow changes.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.components import Labels, Mask
from mbd_perception.segmentation.seam_shape import Points, SeamConfig, is_seam
from mbd_perception.segmentation.table.plane import Plane

Colors = tuple[Points, Points]
PixelWindow = tuple[slice, slice]
# A thing with fewer pixels than this at a quarter of the size is too small to decide.
LEAST_SAMPLE = 25


def split_at_seams(frame: RgbdFrame, objects: Labels, plane: Plane, noise: float, config: SeamConfig) -> Labels:
    """Objects cut at their seams; new numbers follow the largest old one.

    Args:
        frame: what the camera saw.
        objects: (height, width) int32, 0 = none.
        plane: the table, optical frame.
        noise: std of inverse depth [1/m].
        config: thresholds.
    """
    result = objects
    following = int(objects.max(initial=0)) + 1
    for label, window, colors in _two_colored(frame, objects, config):
        rows, columns = window
        # At half size first: print falls in pieces there already.
        coarse = (slice(rows.start, rows.stop, 2), slice(columns.start, columns.stop, 2))
        if _sides(frame.color[coarse], objects[coarse] == label, colors, config) is None:
            continue
        mine = objects[window] == label
        side = _sides(frame.color[window], mine, colors, config)
        part = frame.window(rows.start, columns.start, rows.stop - rows.start, columns.stop - columns.start)
        if side is not None and is_seam(part, (side, mine & ~side), plane, noise, config):
            result = objects.copy() if result is objects else result
            result[window][side] = following
            following += 1
    return result


def _two_colored(frame: RgbdFrame, objects: Labels, config: SeamConfig) -> Iterator[tuple[int, PixelWindow, Colors]]:
    """(label, rectangle around it, its colours) of each object that has two plain colours and no other."""
    coarse = objects[::4, ::4]
    rows, columns = np.nonzero(coarse != 0)
    label = coarse[rows, columns].astype(np.uint16)  # sorted faster than what is wider
    order = np.argsort(label, kind="stable")
    sizes = np.bincount(label)
    ends = np.cumsum(sizes)
    for number in np.flatnonzero(sizes >= LEAST_SAMPLE).tolist():
        one = order[ends[number] - sizes[number] : ends[number]]
        some = one[:: max(1, len(one) // 200)]
        colors = _two_colors(_chromaticity(frame.color[4 * rows[some], 4 * columns[some]], config), config)
        if colors is None:
            continue
        v, u = 4 * rows[one], 4 * columns[one]
        window = (
            slice(max(int(v.min()) - 4, 0), min(int(v.max()) + 5, objects.shape[0])),
            slice(max(int(u.min()) - 4, 0), min(int(u.max()) + 5, objects.shape[1])),
        )
        yield number, window, colors


def _two_colors(tones: Points, config: SeamConfig) -> Colors | None:
    """The two chromaticities that nearly all of (n, 2) are near; None unless there are two, well apart."""
    lit = tones[np.isfinite(tones[:, 0])]
    if len(lit) < config.plain * len(tones):
        return None
    if np.count_nonzero(_alike(lit, lit.mean(axis=0), config)) > (1 - config.least_share) * len(lit):
        return None  # one colour
    first = _mode(lit, config)
    rest = lit[~_alike(lit, first, config)]
    if len(rest) < config.least_share * len(lit):
        return None
    second = _mode(rest, config)
    near = np.count_nonzero(_alike(rest, second, config)) + len(lit) - len(rest)
    if np.linalg.norm(second - first) < config.apart or near < config.plain * len(lit):
        return None
    return first, second


def _sides(color: NDArray[np.uint8], mine: Mask, colors: Colors, config: SeamConfig) -> Mask | None:
    """(height, width) bool, pixels of the second colour; None unless each colour hangs together."""
    tones = _chromaticity(color.reshape(-1, 3), config).reshape(*mine.shape, 2)
    # Nearer to the second: beyond the middle between the two.
    first, second = colors
    closer = (tones - 0.5 * (first + second)) @ (second - first) > 0
    # The majority around takes single pixels, and the blur of colour along the border, to the side they lie on.
    votes, voters = (
        cv2.boxFilter(m.view(np.uint8), cv2.CV_16S, (5, 5), normalize=False) for m in (closer & mine, mine)
    )
    side: Mask = (2 * votes > voters) & mine
    for one in (side, mine & ~side):
        _, _, stats, _ = cv2.connectedComponentsWithStats(one.view(np.uint8), connectivity=4)
        pieces = stats[1:, cv2.CC_STAT_AREA]
        if pieces.sum() < config.least_share * mine.sum() or pieces.max() < config.complete * pieces.sum():
            return None
    return side


def _chromaticity(rgb: NDArray[np.uint8], config: SeamConfig) -> Points:
    """(n, 2) r and g; NaN where it is too dark to decide."""
    values = rgb.astype(np.float64)
    total = values[:, 0] + values[:, 1] + values[:, 2]
    tones = values[:, :2] / np.maximum(total, 1.0)[:, None]
    tones[total < config.dark] = np.nan
    return tones


def _mode(tones: Points, config: SeamConfig) -> Points:
    """The chromaticity around which most lie: the fullest cell of a grid, then the mean of what is near."""
    across = int(1.0 / config.alike) + 1
    cells = (tones * (1.0 / config.alike)).astype(np.intp)
    where = cells[:, 0] * across + cells[:, 1]
    centre = tones[where == np.bincount(where).argmax()].mean(axis=0)
    mean: Points = tones[_alike(tones, centre, config)].mean(axis=0)
    return mean


def _alike(tones: Points, tone: Points, config: SeamConfig) -> Mask:
    """Which of (n, 2) chromaticities are of one colour with another."""
    off = tones - tone
    off *= off
    return off[:, 0] + off[:, 1] <= config.alike**2
