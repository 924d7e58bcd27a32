"""Whether depth values can be metres at all, and what they may be instead."""

from __future__ import annotations

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose
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
# Depths so many times what a known pose lets expect are in other units, and not what stands in the way.
OUT_OF_PROPORTION = 3.0
# What a wrong unit multiplies depths by, and how near to one of these a contradiction is taken for one.
WRONG_UNITS = (5.0, 10.0, 1000.0)
NEAR = 1.25
MILLIMETRES = "values 1000 times too large are millimetres in a float image or cloud: publish metres"
FRACTIONS = (
    "are the depth units right? Values 10 times too large are tenths of a millimetre, 5 times those of a RealSense in "
    "units of 0.2 mm: set its depth unit to 1 mm, or depth_scale in meta.json"
)
METRES = (
    "are the depth units right? Values 1000 times too small are metres taken for millimetres, 5 or 10 times those of "
    "a depth unit of 5 or 10 mm: set it to 1 mm, or depth_scale in meta.json"
)


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
        return MILLIMETRES
    if distance > HIGH:
        return FRACTIONS
    return METRES if 0 < distance < LOW else ""


def height_doubt(height: float, expected: float | None = None) -> str:
    """What to check when the camera seems to be ``height`` [m] above the table; empty when that is plausible.

    Args:
        height: above the table that was found [m].
        expected: above z = 0 of the base frame, which is about the table, as the known pose says [m]; None without one.
    """
    hint = units_hint(height)
    if hint:
        return f"the camera would be {height:.2f} m above the table: {hint}"
    factor = height / expected if expected is not None and expected > LOW else 1.0
    if not any(1 / NEAR < max(factor, 1 / factor) / wrong < NEAR for wrong in WRONG_UNITS):
        return ""
    return (
        f"the camera would be {height:.2f} m above the table, where its pose says {expected:.2f} m above "
        f"z = 0 of the base frame: {FRACTIONS if factor > 1 else METRES}"
    )


def distance_doubt(depth: Depths, camera: Intrinsics, pose: CameraPose | None) -> str:
    """What to check when no table is found, if the depths are out of proportion; empty when they are plausible.

    Args:
        depth: (height, width) float32 [m], 0 = none.
        camera: its camera.
        pose: where the camera stands in the base frame, whose z = 0 is about the table; None when not known.
    """
    typical = typical_depth(depth)
    expected = None if pose is None else _expected_depth(camera, pose)
    if expected is None:
        hint = units_hint(typical)
        return f"half of the depths are beyond {typical:.3g} m: {hint}" if hint else ""
    factor = typical / expected
    hint = MILLIMETRES if factor > 100 else FRACTIONS if factor > OUT_OF_PROPORTION else ""
    hint = METRES if 0 < factor < 1 / OUT_OF_PROPORTION else hint
    text = (
        f"half of the depths are beyond {typical:.3g} m, where the camera's pose lets expect {expected:.2f} m: {hint}"
    )
    return text if hint else ""


def _expected_depth(camera: Intrinsics, pose: CameraPose) -> float | None:
    """The median depth [m] of the plane z = 0 of the base frame; None when it is out of view or too far."""
    columns, rows = camera.rays()
    a, b, c = pose.rotation[2]
    falling = -(a * columns[:, ::8] + (b * rows[::8] + c))
    steep = falling > max(float(pose.position[2]), 0.0) / HORIZON
    if pose.position[2] <= 0 or not steep.any():
        return None
    return float(np.median(float(pose.position[2]) / falling[steep]))
