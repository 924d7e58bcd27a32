"""Point clouds kept in files (.pcd, .ply), read by Open3D, as frames.

An organized PCD keeps its picture. Points in no order are looked at by a camera at their origin, which must be the
optical frame (x right, y down, z forward): every pixel takes the nearest point that falls on it.

Open3D is imported only when a file is read: that takes a second, which a node cannot spare.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from mbd_model.camera.intrinsics import CameraError, Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.clouds import NEUTRAL_GREY, CloudBytes, CloudField, frame_from_cloud
from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame

# The widest picture a loose cloud is seen in, and the narrowest lens that is assumed.
PICTURE = (640, 480)
# An organized cloud as it would travel: what sensor_msgs/PointField calls FLOAT32 (7) and UINT8 (2).
RECORD = np.dtype([("xyz", "<f4", 3), ("rgb", "u1", 3)])
FIELDS = [CloudField(name, 4 * i, 7) for i, name in enumerate("xyz")]
FIELDS += [CloudField(name, 12 + i, 2) for i, name in enumerate("rgb")]
# Bytes of the types of PLY.
PLY_BYTES = {"short": 2, "int16": 2, "ushort": 2, "uint16": 2, "int": 4, "int32": 4, "uint": 4, "uint32": 4}
PLY_BYTES |= {"float": 4, "float32": 4, "double": 8, "float64": 8, "char": 1, "int8": 1, "uchar": 1, "uint8": 1}
# No compression of PCD brings a point below a sixth of a byte.
MOST_POINTS_PER_BYTE = 10


def load_cloud(path: Path) -> RgbdFrame:
    """A frame from a .pcd (ascii, binary, compressed) or .ply (ascii, binary) file; its stamp is 0.

    Raises:
        FrameError: the file is missing, of another kind or not complete, or Open3D is not installed; named in the text.
    """
    sizes = {".pcd": _pcd_size, ".ply": _ply_size}
    kind = path.suffix.lower()
    if kind not in sizes:
        raise FrameError(f"{path}: a cloud file ends in .pcd or .ply")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FrameError(f"{path}: cannot be read ({error.strerror})") from error
    try:
        width, height = sizes[kind](content)
    except (KeyError, ValueError, IndexError) as error:
        raise FrameError(f"{path}: is not a complete {kind} file ({error}); write it again") from error
    if width < 1 or height < 1:
        raise FrameError(f"{path}: its header states {width} x {height} points: write it again with points in it")
    if width * height > MOST_POINTS_PER_BYTE * len(content):
        raise FrameError(f"{path}: its header states {width * height} points but it holds {len(content)} bytes")
    points, colors = _read(path)
    if len(points) != width * height:
        raise FrameError(
            f"{path}: its header states {width * height} points but it holds {len(points)} that can be read: it is cut "
            "off or damaged; write it again"
        )
    try:
        if height == 1:
            return frame_from_points(points, colors)
        records = np.zeros(len(points), dtype=RECORD)
        records["xyz"], records["rgb"] = points, colors
        step = RECORD.itemsize
        return frame_from_cloud(CloudBytes(width, height, FIELDS, step, step * width, records.tobytes()))
    except (FrameError, CameraError) as error:
        raise FrameError(f"{path}: {error}") from error


def _pcd_size(content: bytes) -> tuple[int, int]:
    """(width, height) of a PCD file, which Open3D does not report; raises ValueError when cut off."""
    header: dict[str, list[str]] = {}
    start = 0
    while "DATA" not in header:
        end = content.index(b"\n", start)
        words = content[start:end].decode("ascii", "replace").split()
        start = end + 1
        if words and not words[0].startswith("#"):
            header[words[0]] = words[1:]
    width, height = int(header["WIDTH"][0]), int(header["HEIGHT"][0])
    if header["DATA"] == ["ascii"]:
        _check_rows(content[start:], width * height, len(header["FIELDS"]))
    return width, height


def _ply_size(content: bytes) -> tuple[int, int]:
    """(number of points, 1) of a PLY file; raises ValueError when it is too short for them."""
    end = content.index(b"end_header")
    lines = [line.split() for line in content[:end].decode("ascii", "replace").splitlines()]
    data = content[content.index(b"\n", end) + 1 :]
    encoding = next((words[1] for words in lines if words[:1] == ["format"]), "")
    element, count, properties = "", 0, []
    for words in lines:
        if words[:1] == ["element"]:
            element = words[1]
            count = int(words[2]) if element == "vertex" else count
        elif words[:1] == ["property"] and element == "vertex":
            properties.append(words[1])
    if encoding == "ascii":
        _check_rows(data, count, len(properties))
    elif len(data) < count * sum(PLY_BYTES.get(name, 1) for name in properties):
        raise ValueError(f"it states {count} points but holds {len(data)} bytes")
    return count, 1


def _check_rows(data: bytes, count: int, words: int) -> None:
    """Raises ValueError when a file of text ends too early: Open3D leaves points that are missing uninitialised."""
    rows = [line for line in data.splitlines() if line.strip()][:count]
    if len(rows) < count or (rows and len(rows[-1].split()) < words):
        raise ValueError(f"it states {count} points but holds {len(rows)} rows")


def _read(path: Path) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """(n, 3) points [m], NaN where the file has them, and (n, 3) RGB; no points when Open3D cannot make sense of it."""
    try:
        import open3d
    except (ImportError, OSError) as error:
        raise FrameError(
            f"{path}: clouds are read by Open3D, which cannot be loaded ({error}): run tools/setup, or "
            "pip install -r requirements/files.txt and apt-get install libusb-1.0-0 libgl1 libegl1"
        ) from error
    # Open3D writes its warnings to the terminal; what was wrong is stated in one sentence here instead.
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        try:
            cloud = open3d.t.io.read_point_cloud(path, remove_nan_points=False, remove_infinite_points=False)
        except RuntimeError as error:
            raise FrameError(f"{path}: Open3D cannot read it ({str(error).strip()}); write it again") from error
    if "positions" not in cloud.point:
        return np.zeros((0, 3), dtype=np.float32), np.zeros((0, 3), dtype=np.uint8)
    points = cloud.point["positions"].numpy().astype(np.float32)
    if "colors" not in cloud.point:
        return points, np.full(points.shape, NEUTRAL_GREY, dtype=np.uint8)
    colors = cloud.point["colors"].numpy()
    if np.issubdtype(colors.dtype, np.floating):
        colors = np.nan_to_num(255 * colors).clip(0, 255)
    return points, colors.astype(np.uint8)


def frame_from_points(points: NDArray[np.float32], colors: NDArray[np.uint8]) -> RgbdFrame:
    """A frame from points in no order.

    The lens is chosen so that all points are in the picture, and so coarse that neighbouring points leave no gaps.

    Args:
        points: (n, 3) x, y, z [m, optical frame].
        colors: (n, 3) RGB.

    Raises:
        FrameError: no point before the camera.
    """
    x, y, z = points.astype(np.float64).T
    seen = np.isfinite(x) & np.isfinite(y) & np.isfinite(z) & (z > 1e-3)
    if np.count_nonzero(seen) < 100:
        raise FrameError(
            f"{np.count_nonzero(seen)} of its {len(points)} points lie before the camera: they must be in the optical "
            "frame (x right, y down, z forward)"
        )
    across, down, depth = (x / np.maximum(z, 1e-3))[seen], (y / np.maximum(z, 1e-3))[seen], z[seen]
    low, high = np.array([across.min(), down.min()]), np.array([across.max(), down.max()])
    span = np.maximum(high - low, 1e-3)
    # Two points a pixel on average: hardly a pixel without one.
    pixels = min(len(depth) / 2, PICTURE[0] * PICTURE[1])
    focal = min(math.sqrt(pixels / float(span.prod())), *(np.array(PICTURE) / span))
    width, height = (int(v) + 1 for v in span * focal)
    camera = Intrinsics(focal, focal, -low[0] * focal, -low[1] * focal, width=width, height=height)
    u = np.rint(across * focal + camera.cx).astype(int).clip(0, width - 1)
    v = np.rint(down * focal + camera.cy).astype(int).clip(0, height - 1)
    order = np.argsort(-depth, kind="stable")  # the nearest last: it stays
    picture = np.zeros((height, width), dtype=np.float32)
    picture[v[order], u[order]] = depth[order]
    color = np.full((height, width, 3), NEUTRAL_GREY, dtype=np.uint8)
    color[v[order], u[order]] = colors[seen][order]
    return make_frame(color, picture, camera)
