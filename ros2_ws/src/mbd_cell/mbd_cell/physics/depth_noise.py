"""What a structured-light camera makes of a perfect depth image.

After Khoshelham & Elberink 2012 and Nguyen et al. 2012: axial noise that grows with the square of the distance,
disparities in eighths of a pixel, and no return where the surface is seen at a grazing angle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BASELINE = 0.075  # projector to camera [m]
SUBPIXEL = 0.125  # step of the disparity [pixel]
GRAZING = (4.0, 12.0)  # tangent of the angle to the surface's normal from which returns fade, and where none is left
LOST = 0.001  # share of pixels lost anywhere


def noise_std(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Standard deviation of the axial noise [m] at that depth [m]."""
    return np.asarray(0.0012 + 0.0019 * (depth - 0.4) ** 2, dtype=np.float32)


def add_noise(depth: NDArray[np.float32], focal: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Noisy depth (H, W) [m], 0 = no return.

    Args:
        depth: perfect depth (H, W) [m], 0 = nothing there.
        focal: focal length [pixel].
        rng: the only source of chance.
    """
    seen = depth > 0.0
    safe = np.where(seen, depth, np.float32(1.0))
    noisy = safe + noise_std(safe) * rng.standard_normal(depth.shape, dtype=np.float32)
    disparity = np.float32(focal * BASELINE) / np.maximum(noisy, np.float32(0.05))
    quantised = np.float32(SUBPIXEL) * np.round(disparity / np.float32(SUBPIXEL))
    noisy = np.float32(focal * BASELINE) / np.maximum(quantised, np.float32(SUBPIXEL))
    pixel = safe / np.float32(focal)
    slope = np.maximum(_steepest(safe, 0), _steepest(safe, 1)) / pixel
    fade = np.clip((slope - GRAZING[0]) / (GRAZING[1] - GRAZING[0]), 0.0, 1.0)
    lost = rng.random(depth.shape, dtype=np.float32) < np.maximum(fade, np.float32(LOST))
    return np.where(seen & ~lost, noisy, np.float32(0.0))


def _steepest(depth: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Smaller of the two one-sided differences along the axis: an edge costs pixels of the surface that is steep."""
    step = np.abs(np.diff(depth, axis=axis))
    edge = np.take(step, [0], axis=axis) * 0.0 + np.float32(np.inf)
    before = np.concatenate((edge, step), axis=axis)
    after = np.concatenate((step, edge), axis=axis)
    return np.asarray(np.minimum(before, after), dtype=np.float32)
