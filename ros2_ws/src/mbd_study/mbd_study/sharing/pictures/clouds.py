"""Point clouds of a bag: the points outside of the table's volume, and those of a face, are dropped."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from mbd_bag.errors import BagError
from mbd_model.errors import MbdError
from mbd_perception.frames.clouds import CloudBytes, CloudField
from numpy.typing import NDArray

from mbd_study.sharing.pictures.faces import FaceBox
from mbd_study.sharing.pictures.volume import TableVolume


def cover_cloud(cloud: Any, volume: TableVolume, faces: Sequence[FaceBox]) -> None:
    """Drop points of a decoded PointCloud2, in place: an organized cloud has NaN there, another is shorter.

    Args:
        cloud: in the camera's or the base frame.
        volume: of the table.
        faces: in the camera's picture.

    Raises:
        BagError: another frame, or a layout that cannot be read; nothing is changed.
    """
    frame = str(cloud.header.frame_id)
    if frame not in (volume.camera_frame, volume.base_frame):
        raise BagError(f"it is in the frame '{frame}', of which the bag does not say where it lies")
    fields = [CloudField(f.name, int(f.offset), int(f.datatype)) for f in cloud.fields]
    layout = CloudBytes(
        int(cloud.width),
        int(cloud.height),
        fields,
        int(cloud.point_step),
        int(cloud.row_step),
        memoryview(bytes(cloud.data)),
        bool(cloud.is_bigendian),
    )
    try:
        axes = [layout.column(name) for name in "xyz"]
    except (MbdError, ValueError) as error:
        raise BagError(str(error)) from error
    if any(axis is None or axis.dtype.kind != "f" for axis in axes):
        raise BagError("it has no x, y and z as floating numbers")
    points = np.stack([np.asarray(axis, np.float64).ravel() for axis in axes], axis=1)
    keep = _kept(points, frame == volume.camera_frame, volume, faces)
    step, width = layout.point_step, layout.width
    rows = np.frombuffer(layout.data, np.uint8, layout.height * layout.row_step).reshape(layout.height, -1)
    records = rows[:, : width * step].reshape(-1, step).copy()
    if layout.height == 1:
        records = records[keep]
        cloud.width = len(records)
    else:
        records[~keep] = 0
        nowhere = np.frombuffer(np.array([np.nan], axes[0].dtype).tobytes(), np.uint8)  # type: ignore[union-attr]
        for field in (f for f in fields if f.name in "xyz"):
            records[~keep, field.offset : field.offset + len(nowhere)] = nowhere
        cloud.is_dense = False
    cloud.row_step = int(cloud.width) * step
    cloud.data = np.ascontiguousarray(records).reshape(-1)


def _kept(
    points: NDArray[np.float64], by_camera: bool, volume: TableVolume, faces: Sequence[FaceBox]
) -> NDArray[np.bool_]:
    """Which of (n, 3) points stay; ``by_camera``: they are in the optical frame, else in the base frame."""
    finite = np.logical_and.reduce(np.isfinite(points), axis=1)
    clean = np.where(finite[:, None], points, 0.0)
    seen = clean if by_camera else (clean - volume.pose.position) @ volume.pose.rotation
    keep: NDArray[np.bool_] = finite & volume.contains(volume.pose.to_base(clean) if by_camera else clean)
    before = seen[:, 2] > 1e-6
    z = np.where(before, seen[:, 2], 1.0)
    u, v = volume.camera.fx * seen[:, 0] / z + volume.camera.cx, volume.camera.fy * seen[:, 1] / z + volume.camera.cy
    for face in faces:
        keep &= ~(before & (u >= face.left) & (u < face.right) & (v >= face.top) & (v < face.bottom))
    return keep
