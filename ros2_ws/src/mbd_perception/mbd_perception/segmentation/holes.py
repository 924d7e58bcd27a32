"""Patches that an object surrounds: the bottom of a bowl that is as low as the table, pixels that were lost."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage
from mbd_perception.segmentation.components import Labels
from mbd_perception.segmentation.regions import SQUARE

NOTHING = np.uint16(np.iinfo(np.uint16).max)


@dataclass(frozen=True)
class Patches:
    """Pixels without label that labelled ones cut off from the edge of the picture.

    Attributes:
        window: rectangle of the picture that holds them all.
        at: (n,) flat indices of their pixels in that window.
        number: (n,) which patch each pixel belongs to, 0..count - 1.
        count: number of patches.
        seen: (n,) bool; pixels with depth, the only ones that are filled.
    """

    window: tuple[slice, slice]
    at: NDArray[np.intp]
    number: NDArray[np.int32]
    count: int
    seen: NDArray[np.bool_]


def enclosed_patches(labels: Labels, depth: FloatImage) -> Patches | None:
    """The enclosed patches of a label picture, (height, width), 0 = none; None when there are none."""
    outside = cv2.copyMakeBorder((labels != 0).view(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    cv2.floodFill(outside, None, (0, 0), 1)
    holes = (outside == 0).view(np.uint8)
    left, top, width, height = cv2.boundingRect(holes)
    if width == 0:
        return None
    # One pixel more on each side, for what surrounds them; in the picture with the border an enclosed one has it.
    holed = holes[top - 1 : top + height + 1, left - 1 : left + width + 1]
    count, found = cv2.connectedComponents(holed, connectivity=4, ltype=cv2.CV_32S)
    at = np.flatnonzero(found != 0)
    window = (slice(top - 2, top + height), slice(left - 2, left + width))
    return Patches(window, at, found.ravel()[at] - 1, count - 1, depth[window].ravel()[at] > 0)


def fill_holes(labels: Labels, patches: Patches | None) -> Labels:
    """Labels with each patch given to what alone surrounds it."""
    if patches is None:
        return labels
    filled = labels.copy()
    part = labels[patches.window].astype(np.uint16)
    highest = cv2.dilate(part, SQUARE).ravel()[patches.at]
    lowest = cv2.erode(np.where(part == 0, NOTHING, part), SQUARE).ravel()[patches.at]
    most, least = np.zeros(patches.count, dtype=np.uint16), np.full(patches.count, NOTHING)
    np.maximum.at(most, patches.number, highest)
    np.minimum.at(least, patches.number, lowest)
    own = np.where(most == least, most, 0)[patches.number]
    take = patches.seen & (own > 0)
    rows, columns = np.divmod(patches.at[take], part.shape[1])
    filled[patches.window][rows, columns] = own[take]
    return filled
