"""Organized point clouds of any memory layout, as frames.

A cloud arrives as bytes with a list of fields. Nothing is assumed about their order, offsets, padding or byte order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame

# Codes of sensor_msgs/PointField.
DATATYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
NEUTRAL_GREY = 128


@dataclass(frozen=True)
class CloudField:
    """One field of a point: name, offset [byte], sensor_msgs/PointField datatype code."""

    name: str
    offset: int
    datatype: int


@dataclass(frozen=True)
class CloudBytes:
    """A point cloud as it travels.

    Attributes:
        width, height: points a row, rows; height 1 means not organized.
        fields: what each point holds.
        point_step, row_step: bytes from one point, one row, to the next.
        data: the bytes.
        bigendian: byte order of numbers.
    """

    width: int
    height: int
    fields: Sequence[CloudField]
    point_step: int
    row_step: int
    data: bytes | memoryview
    bigendian: bool = False

    def column(self, name: str, kind: str | None = None, offset: int = 0) -> NDArray[np.generic] | None:
        """A (height, width) view of one field, or None when there is no such field.

        Args:
            name: of the field.
            kind: numpy type to read it as, in place of its own.
            offset: bytes into the field.

        Raises:
            FrameError: unknown datatype, or a layout that reaches beyond the data.
        """
        found = next((f for f in self.fields if f.name == name), None)
        if found is None:
            return None
        if found.datatype not in DATATYPES:
            raise FrameError(f"point cloud field '{name}' has datatype {found.datatype}; PointField has 1..8")
        dtype = np.dtype(kind or DATATYPES[found.datatype]).newbyteorder(">" if self.bigendian else "<")
        start = found.offset + offset
        last = (self.height - 1) * self.row_step + (self.width - 1) * self.point_step + start + dtype.itemsize
        if start + dtype.itemsize > self.point_step or self.width * self.point_step > self.row_step:
            raise FrameError(
                f"point cloud field '{name}' at byte {start} does not fit point_step {self.point_step}, "
                f"row_step {self.row_step} and width {self.width}: the publisher's layout is wrong"
            )
        size = len(self.data)
        if last > size:
            raise FrameError(f"point cloud is cut off: its layout needs {last} bytes, it has {size}")
        return np.ndarray((self.height, self.width), dtype, self.data, start, (self.row_step, self.point_step))


def frame_from_cloud(cloud: CloudBytes, stamp: float = 0.0, camera: Intrinsics | None = None) -> RgbdFrame:
    """A frame from an organized cloud in the optical frame.

    Args:
        cloud: the cloud.
        stamp: when [s].
        camera: its camera; worked out from the points when None.

    Raises:
        FrameError: empty, unorganized or truncated cloud, fields missing, or points no pinhole camera sees.
    """
    if cloud.width < 1 or cloud.height < 1 or len(cloud.data) == 0:
        raise FrameError("the point cloud is empty: check that the camera is running and its driver publishes points")
    if cloud.height == 1:
        raise FrameError(
            f"the point cloud is not organized (height 1, {cloud.width} points): "
            "turn on the driver's organized (ordered) cloud, or use colour and depth images"
        )
    axes = [cloud.column(name) for name in ("x", "y", "z")]
    if any(a is None for a in axes):
        raise FrameError(f"the point cloud has fields {[f.name for f in cloud.fields]}, expected x, y and z among them")
    x, y, z = (np.asarray(a, dtype=np.float32) for a in axes)
    finite = np.isfinite(x) & np.isfinite(y) & np.isfinite(z) & (z > 0)
    if not finite.any():
        raise FrameError(
            f"none of the {z.size} points of the cloud is valid (all NaN, infinite or behind the camera): "
            "check that the camera sees the table, within its range"
        )
    optics = camera or fit_intrinsics(x, y, z, finite)
    return make_frame(cloud_color(cloud), np.where(finite, z, np.float32(0)), optics, stamp)


def cloud_color(cloud: CloudBytes) -> NDArray[np.uint8]:
    """(height, width, 3) RGB of a cloud: packed rgb or rgba, separate r, g, b, or neutral grey when it has none."""
    for name in ("rgb", "rgba"):
        # 0xAARRGGBB whatever type the field claims to be.
        packed = cloud.column(name, "u4")
        if packed is not None:
            value = packed.astype(np.uint32)
            return np.stack([(value >> shift & 0xFF).astype(np.uint8) for shift in (16, 8, 0)], axis=-1)
    parts = [cloud.column(name) for name in ("r", "g", "b")]
    if all(p is not None for p in parts):
        values = np.stack([np.asarray(p, dtype=np.float64) for p in parts], axis=-1)
        floating = any(p is not None and p.dtype.kind == "f" for p in parts)
        scaled = values * 255.0 if floating and np.nanmax(values, initial=0.0) <= 1.0 else values
        return np.clip(np.nan_to_num(scaled), 0, 255).astype(np.uint8)
    return np.full((cloud.height, cloud.width, 3), NEUTRAL_GREY, dtype=np.uint8)


def fit_intrinsics(
    x: NDArray[np.float32], y: NDArray[np.float32], z: NDArray[np.float32], valid: NDArray[np.bool_]
) -> Intrinsics:
    """The pinhole camera of an organized cloud: column = fx x/z + cx, row = fy y/z + cy, by least squares.

    Raises:
        FrameError: too few points, or points that no pinhole camera at the origin sees in these pixels.
    """
    height, width = z.shape
    v, u = np.nonzero(valid)
    step = max(1, len(u) // 5000)
    v, u = v[::step], u[::step]
    fits = []
    for pixel, coordinate in ((u, x), (v, y)):
        ratio = coordinate[v, u].astype(np.float64) / z[v, u]  # float32 overflows where z is next to nothing
        if len(ratio) < 10 or np.ptp(ratio) < 1e-6:
            raise FrameError(f"the cloud has {len(ratio)} usable points, too few to know its camera: use camera_info")
        slope, offset = np.polyfit(ratio, pixel, 1)
        if slope <= 0 or np.abs(ratio * slope + offset - pixel).mean() > 2.0:
            raise FrameError(
                "the points of the cloud do not lie on the rays of its pixels: publish it in the optical frame "
                "(x right, y down, z forward), not in the base frame"
            )
        fits.append((float(slope), float(offset)))
    (fx, cx), (fy, cy) = fits
    return Intrinsics(fx=fx, fy=fy, cx=cx, cy=cy, width=width, height=height)
