"""A quantile without interpolation, found by partition."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def quantile(values: NDArray[np.floating], share: float) -> float:
    """The value below which that share of the values lies, without interpolation; values are not empty."""
    at = round(share * (len(values) - 1))
    return float(np.partition(values, at)[at])
