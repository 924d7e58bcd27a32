"""Whether depth values can be metres at all, and what they may be instead."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Depths = NDArray[np.float32]
# Half of the pixels of a picture of a table lie nearer than this [m]; what lies farther is no depth in metres.
FARTHEST = 50.0
# No table is farther from its camera than this [m]: beyond, depth cameras return noise.
HORIZON = 10.0
# Cameras are mounted lower than this above a table [m]; a higher one is pointed out, not refused.
HIGH = 3.0
# Nor lower than this [m].
LOW = 0.1


def typical_depth(depth: Depths) -> float:
    """The median of the valid pixels of a depth image, (height, width) float32 [m]; 0 when none is valid."""
    sample = depth[::8, ::8]
    valid = sample[sample > 0]
    if valid.size == 0:
        valid = depth[depth > 0] if cv2.countNonZero(depth) else valid
    return float(np.median(valid)) if valid.size else 0.0


def units_hint(distance: float) -> str:
    """What to check when the camera seems to be ``distance`` [m] away from a table; empty when that is plausible."""
    if distance > FARTHEST:
        return "values 1000 times too large are millimetres in a float image or cloud: publish metres"
    if distance > HIGH:
        return (
            "are the depth units right? Values 10 times too large are tenths of a millimetre, 5 times those of a "
            "RealSense in units of 0.2 mm: set its depth unit to 1 mm, or depth_scale in meta.json"
        )
    if 0 < distance < LOW:
        return "are the depth units right? Values 1000 times too small are metres taken for millimetres"
    return ""
