"""Single missing pixels closed, so that a surface with holes all over stays one surface."""

from __future__ import annotations

import cv2
import numpy as np

from mbd_perception.frames.frame import FloatImage

# Fewer gaps than this share of the pixels do not take surfaces apart.
FEW = 0.02
# So many of the eight neighbours must have depth.
NEIGHBOURS = 3
ROUNDS = 2


def with_gaps_closed(depth: FloatImage, noise: float) -> FloatImage:
    """Depth with each gap filled whose neighbours agree: the mean of their inverse depths.

    Neighbours agree when they differ by no more than noise and a slope of 60 degrees would make them: across a
    silhouette they do not. The picture itself is returned when hardly any pixel is missing amid others.

    Args:
        depth: (height, width) float32 [m], 0 = none.
        noise: std of inverse depth [1/m].
    """
    rows = depth[1::8]
    amid = (rows[:, 1:-1] == 0) & (rows[:, :-2] > 0) & (rows[:, 2:] > 0)
    if np.count_nonzero(amid) <= FEW * amid.size:
        return depth
    for _ in range(ROUNDS):
        depth = _closed_once(depth, noise)
    return depth


def _closed_once(depth: FloatImage, noise: float) -> FloatImage:
    """Gaps that have enough neighbours, closed."""
    valid = depth > 0
    w = np.divide(np.float32(1), depth, out=np.zeros_like(depth), where=valid)
    count = cv2.boxFilter(valid.view(np.uint8), cv2.CV_16S, (3, 3), normalize=False)
    total = cv2.boxFilter(w, -1, (3, 3), normalize=False)
    square = np.ones((3, 3), np.uint8)
    low = cv2.erode(np.where(valid, w, np.float32(1e3)), square)
    high = cv2.dilate(w, square)
    agree = high - low <= np.float32(6 * noise) + np.float32(0.02) * high
    take = ~valid & (count >= NEIGHBOURS) & agree
    filled: FloatImage = depth.copy()
    filled[take] = count[take] / total[take]
    return filled
