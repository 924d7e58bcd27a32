"""One face through two regions: a plane, or a cylinder that lies along the way between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbd_perception.quantile import median
from mbd_perception.segmentation.borders import Relief

# A face of fewer pixels says nothing about how it goes on.
SMALLEST = 12
RIDGE = 1e-12 * np.eye(4)


def joint_error(
    relief: Relief, one: NDArray[np.intp], other: NDArray[np.intp], along: NDArray[np.float64], *, noise: float
) -> float:
    """Median error of a face through two regions that is straight along ``along`` and may bend across.

    Args:
        relief: of the picture.
        one: (n,) flat pixels of a region.
        other: (m,) of the other.
        along: (2,) unit vector, u v.
        noise: std of inverse depth [1/m], in which the error is given.

    Returns:
        the larger of the two regions' errors; infinite where one has too few pixels with depth.
    """
    values = relief.w.ravel()
    one, other = one[values[one] > 0], other[values[other] > 0]
    if min(len(one), len(other)) < SMALLEST:
        return np.inf
    pixels = np.concatenate([one, other])
    v, u = np.divmod(pixels, relief.w.shape[1])
    scale = 1.0 / relief.focal
    t, s = ((u * along[0] + v * along[1]) * scale), ((v * along[0] - u * along[1]) * scale)
    t, s = t - t.mean(), s - s.mean()
    terms = np.stack([np.ones(len(t)), t, s, s * s], axis=1)
    w = values[pixels].astype(np.float64)
    # Each region counts the same, however many of its pixels are looked at.
    weight = np.concatenate([np.full(len(one), 1.0 / len(one)), np.full(len(other), 1.0 / len(other))])
    errors = [np.inf, np.inf]
    for _ in range(2):
        weighted = terms.T * weight
        # A little regularised: a strip one pixel wide does not bend across.
        fit = np.linalg.solve(weighted @ terms + RIDGE, weighted @ w)
        error = np.abs(terms @ fit - w)
        errors = [median(error[: len(one)]), median(error[len(one) :])]
        weight = weight / (1.0 + (error / max(3.0 * noise, 2.0 * max(errors))) ** 2)
    return max(errors) / (0.6745 * noise)
