"""Quantiles and the median of few values, found by partition, without the overhead of those of numpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def quantile(values: NDArray[np.floating], share: float) -> float:
    """The value below which that share of the values lies, without interpolation; values are not empty."""
    at = round(share * (len(values) - 1))
    return float(np.partition(values, at)[at])


def interpolated_quantile(values: NDArray[np.floating], share: float) -> float:
    """The same with linear interpolation between the two nearest values, as that of numpy."""
    place = share * (len(values) - 1)
    low = int(place)
    ordered = np.partition(values, (low, min(low + 1, len(values) - 1)))
    first, second = float(ordered[low]), float(ordered[min(low + 1, len(values) - 1)])
    return first + (place - low) * (second - first)


def median(values: NDArray[np.floating]) -> float:
    """The median, as that of numpy: the mean of the two middle ones of an even number; values are not empty."""
    high = len(values) // 2
    if len(values) % 2:
        return float(np.partition(values, high)[high])
    ordered = np.partition(values, (high - 1, high))
    return float(0.5 * (ordered[high - 1] + ordered[high]))
