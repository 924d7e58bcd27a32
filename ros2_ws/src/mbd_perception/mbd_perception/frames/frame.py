"""One RGB-D frame, validated once where it enters."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_perception.frames.units import FARTHEST, typical_depth, units_hint

FloatImage = NDArray[np.float32]
ColorImage = NDArray[np.uint8]

# Std of inverse depth [1/m] of structured light (Khoshelham & Elberink 2012), until a frame's own is measured.
DEPTH_NOISE = 1.5e-3
# What a uint16 depth image holds where the distance is larger than it can hold.
SATURATED = 65535


class FrameError(MbdError):
    """A frame that cannot be used: sizes, encoding, or no depth in it."""


@dataclass(frozen=True)
class RgbdFrame:
    """Colour registered to depth.

    Attributes:
        color: (height, width, 3) uint8 RGB.
        depth: (height, width) float32 z in the optical frame [m]; 0 = no return. Never NaN, infinite or negative.
        camera: the pinhole camera both were taken with.
        stamp: when [s].
    """

    color: ColorImage
    depth: FloatImage
    camera: Intrinsics
    stamp: float = 0.0

    def window(self, top: int, left: int, height: int, width: int) -> RgbdFrame:
        """A part of the frame, cut at the picture's edges [px]; its depth is a copy in one piece."""
        part = (slice(top, top + height), slice(left, left + width))
        depth = np.ascontiguousarray(self.depth[part])
        camera = self.camera.window(top, left, *depth.shape)
        return RgbdFrame(self.color[part], depth, camera, self.stamp)


def make_frame(
    color: NDArray[np.uint8],
    depth: NDArray[np.uint16] | NDArray[np.float32],
    camera: Intrinsics,
    stamp: float = 0.0,
    depth_scale: float = 0.001,
) -> RgbdFrame:
    """A frame from raw images.

    Args:
        color: (height, width, 3) uint8 RGB.
        depth: (height, width); uint16 with 0 and 65535 = no return, or floats in metres with NaN, infinity or
            anything not positive = no return.
        camera: its pinhole camera.
        stamp: when [s].
        depth_scale: metres per unit of uint16 depth; 0.001 for millimetres.

    Raises:
        FrameError: sizes that do not match, wrong types, or no depth that can be metres.
    """
    if depth.ndim != 2 or depth.size == 0:
        raise FrameError(f"depth image of shape {depth.shape} is not a (height, width) picture; is the camera running?")
    if color.ndim != 3 or color.shape[2] != 3 or color.dtype != np.uint8:
        raise FrameError(f"colour image of shape {color.shape}, type {color.dtype} is not (height, width, 3) uint8 RGB")
    if color.shape[:2] != depth.shape:
        raise FrameError(
            f"colour image is {color.shape[1]}x{color.shape[0]} but depth is {depth.shape[1]}x{depth.shape[0]}: "
            "use the depth stream that is registered to colour"
        )
    if (camera.height, camera.width) != depth.shape:
        raise FrameError(
            f"camera_info states {camera.width}x{camera.height} but the images are {depth.shape[1]}x{depth.shape[0]}: "
            "subscribe to the camera_info of the same stream"
        )
    if depth.dtype == np.uint16:
        # Saturated pixels are no distance.
        clean = cv2.inRange(depth, SATURATED, SATURATED)
        metres = cv2.multiply(depth, depth_scale, dtype=cv2.CV_32F)
        if cv2.countNonZero(clean):
            metres[clean > 0] = 0
    elif np.issubdtype(depth.dtype, np.floating):
        metres = np.where(np.isfinite(depth) & (depth > 0), depth, 0).astype(np.float32)
    else:
        raise FrameError(f"depth type {depth.dtype} is neither uint16 (millimetres) nor floating (metres)")
    if cv2.countNonZero(metres) == 0:
        raise FrameError(
            "no pixel of the depth image has a value (all zero or NaN, or saturated at 65535): check that the "
            "camera sees the table, that its projector is on and that nothing covers it"
        )
    typical = typical_depth(metres)
    if typical > FARTHEST:
        raise FrameError(f"half of the depth pixels are farther than {typical:.0f} m: {units_hint(typical)}")
    return RgbdFrame(color=color, depth=metres, camera=camera, stamp=stamp)


def fuse(frames: list[RgbdFrame]) -> RgbdFrame:
    """The pixelwise median of frames of a still scene: depth noise falls and single-frame holes close.

    A pixel has depth when at least half of the frames do. Colour is the median too; stamp and camera are the last's.

    Raises:
        FrameError: no frame, or frames of different cameras.
    """
    if not frames:
        raise FrameError("no frame to fuse: wait for at least one")
    last = frames[-1]
    if len(frames) == 1:
        return last
    if any(f.camera != last.camera for f in frames):
        raise FrameError("the camera changed between the frames of one observation: observe again")
    stack = np.sort(np.stack([np.where(f.depth > 0, f.depth, np.inf) for f in frames]), axis=0)
    valid = np.isfinite(stack).sum(axis=0)
    middle = np.maximum(valid - 1, 0) // 2
    depth = np.take_along_axis(stack, middle[None], axis=0)[0]
    depth = np.where(2 * valid >= len(frames), depth, 0).astype(np.float32)
    color = np.sort(np.stack([f.color for f in frames]), axis=0)[(len(frames) - 1) // 2]
    return RgbdFrame(color=color, depth=depth, camera=last.camera, stamp=last.stamp)
