"""A trajectory's points as joint targets, tick by tick."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mbd_cell.physics.simulation import TICK_NS


def interpolated(
    start: NDArray[np.float64],
    times: NDArray[np.float64],
    positions: NDArray[np.float64],
    velocities: NDArray[np.float64] | None,
) -> Iterator[NDArray[np.float64]]:
    """Joint targets tick by tick: cubic through positions and velocities, straight where there are none."""
    if times[0] > 0:
        times, positions = np.concatenate(([0.0], times)), np.vstack((start, positions))
        if velocities is not None:
            velocities = np.vstack((np.zeros_like(start), velocities))
    tick = TICK_NS * 1e-9
    for t in np.arange(tick, times[-1] + tick, tick):
        i = int(np.clip(np.searchsorted(times, t) - 1, 0, len(times) - 2))
        span = times[i + 1] - times[i]
        s = min(1.0, (t - times[i]) / span)
        if velocities is None:
            yield positions[i] + s * (positions[i + 1] - positions[i])
            continue
        yield (
            (1 + 2 * s) * (1 - s) ** 2 * positions[i]
            + s * (1 - s) ** 2 * span * velocities[i]
            + s * s * (3 - 2 * s) * positions[i + 1]
            + s * s * (s - 1) * span * velocities[i + 1]
        )
