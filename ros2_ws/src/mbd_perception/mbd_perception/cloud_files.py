"""Point clouds kept in files (.pcd, .ply; ascii or binary), as frames.

An organized PCD keeps its picture. Points in no order are looked at by a camera at their origin, which must be the
optical frame (x right, y down, z forward): every pixel takes the nearest point that falls on it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbd_perception.clouds import NEUTRAL_GREY, CloudBytes, CloudField, frame_from_cloud
from mbd_perception.frame import FrameError, Intrinsics, RgbdFrame, make_frame

PCD_TYPES = {("F", 4): 7, ("F", 8): 8, ("U", 1): 2, ("U", 2): 4, ("U", 4): 6, ("I", 1): 1, ("I", 2): 3, ("I", 4): 5}
PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
# The widest picture a loose cloud is seen in, and the narrowest lens that is assumed.
PICTURE = (640, 480)


def load_cloud(path: Path) -> RgbdFrame:
    """A frame from a .pcd or .ply file; its stamp is 0.

    Raises:
        FrameError: the file is missing, of another kind, or not whole; the text names it.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FrameError(f"{path}: cannot be read ({error.strerror})") from error
    readers = {".pcd": _pcd_points, ".ply": _ply_points}
    if path.suffix.lower() not in readers:
        raise FrameError(f"{path}: a cloud file ends in .pcd or .ply")
    try:
        width, height, points = readers[path.suffix.lower()](content)
        if height > 1:
            return frame_from_cloud(_as_bytes(width, height, points))
        return frame_from_points(points)
    except FrameError as error:
        raise FrameError(f"{path}: {error}") from error
    except (KeyError, ValueError, IndexError) as error:
        raise FrameError(f"{path}: is not a whole {path.suffix} file ({error}); write it again") from error


def _pcd_points(content: bytes) -> tuple[int, int, NDArray[Any]]:
    """(width, height, structured points) of a PCD file."""
    header: dict[str, list[str]] = {}
    start = 0
    while "DATA" not in header:
        end = content.index(b"\n", start)
        words = content[start:end].decode("ascii", "replace").split()
        start = end + 1
        if words and not words[0].startswith("#"):
            header[words[0]] = words[1:]
    counts = [int(c) for c in header.get("COUNT", ["1"] * len(header["FIELDS"]))]
    parts: list[Any] = []
    for i, (name, size, kind, count) in enumerate(
        zip(header["FIELDS"], header["SIZE"], header["TYPE"], counts, strict=True)
    ):
        if (kind, int(size)) not in PCD_TYPES:
            raise FrameError(f"field '{name}' has type {kind}{size}, which PCD does not have")
        code = f"<{kind.lower()}{size}"
        parts.append((f"padding{i}" if name == "_" else name, code, (count,)) if count > 1 else (name, code))
    dtype = np.dtype([(f"padding{i}", *p[1:]) if p[0] == "_" else p for i, p in enumerate(parts)])
    width, height = int(header["WIDTH"][0]), int(header["HEIGHT"][0])
    return width, height, _records(content[start:], dtype, width * height, header["DATA"][0])


def _ply_points(content: bytes) -> tuple[int, int, NDArray[Any]]:
    """(number of points, 1, structured points) of a PLY file; vertices must be its first element."""
    end = content.index(b"end_header")
    lines = [line.split() for line in content[:end].decode("ascii", "replace").splitlines()]
    encoding = next(words[1] for words in lines if words and words[0] == "format")
    elements = [i for i, words in enumerate(lines) if words and words[0] == "element"]
    first = lines[elements[0]]
    if first[1] != "vertex":
        raise FrameError(f"its first element is '{first[1]}', expected 'vertex'")
    last = elements[1] if len(elements) > 1 else len(lines)
    order = ">" if "big" in encoding else "<"
    names = {"red": "r", "green": "g", "blue": "b"}
    properties = [words for words in lines[elements[0] + 1 : last] if words and words[0] == "property"]
    dtype = np.dtype([(names.get(words[2], words[2]), order + PLY_TYPES[words[1]]) for words in properties])
    count = int(first[2])
    start = content.index(b"\n", end) + 1
    return count, 1, _records(content[start:], dtype, count, encoding)


def _records(data: bytes, dtype: np.dtype[Any], count: int, encoding: str) -> NDArray[Any]:
    """That many structured points; raises FrameError for an encoding that is not read here, or too little data."""
    if encoding == "ascii":
        rows = data.decode("ascii", "replace").splitlines()[:count]
        if len(rows) < count:
            raise FrameError(f"it says {count} points but holds {len(rows)}")
        points = np.zeros(count, dtype=dtype)
        values = np.array([row.split()[: len(dtype.names or ())] for row in rows])
        for column, name in enumerate(dtype.names or ()):
            points[name] = values[:, column].astype(dtype[name].base)
        return points
    if encoding not in ("binary", "binary_little_endian", "binary_big_endian"):
        raise FrameError(f"its data is '{encoding}'; write it as ascii or (uncompressed) binary")
    if len(data) < count * dtype.itemsize:
        raise FrameError(f"it says {count} points of {dtype.itemsize} bytes but holds {len(data)} bytes")
    return np.frombuffer(data, dtype=dtype, count=count)


def _as_bytes(width: int, height: int, points: NDArray[Any]) -> CloudBytes:
    """Structured points as the cloud they would travel as."""
    codes = {("f", 4): 7, ("f", 8): 8, ("u", 1): 2, ("u", 2): 4, ("u", 4): 6, ("i", 1): 1, ("i", 2): 3, ("i", 4): 5}
    fields = []
    for name, (dtype, offset, *_) in (points.dtype.fields or {}).items():
        if dtype.subdtype is None:
            fields.append(CloudField(name, offset, codes[dtype.kind, dtype.itemsize]))
    step = points.dtype.itemsize
    return CloudBytes(width, height, fields, step, step * width, points.tobytes())


def frame_from_points(points: NDArray[Any]) -> RgbdFrame:
    """A frame from structured points in no order, optical frame.

    The lens is chosen so that all points are in the picture, and so coarse that neighbouring points leave no gaps.

    Raises:
        FrameError: fields missing, or no point before the camera.
    """
    if any(name not in (points.dtype.names or ()) for name in ("x", "y", "z")):
        raise FrameError(f"it has fields {points.dtype.names}, expected x, y and z among them")
    x, y, z = (points[name].astype(np.float64) for name in ("x", "y", "z"))
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
    color[v[order], u[order]] = _colors(points)[seen][order]
    return make_frame(color, picture, camera)


def _colors(points: NDArray[Any]) -> NDArray[np.uint8]:
    """(n, 3) RGB of structured points; neutral grey when they have none."""
    names = points.dtype.names or ()
    if all(name in names for name in "rgb"):
        return np.stack([points[name] for name in "rgb"], axis=1).astype(np.uint8)
    for name in ("rgb", "rgba"):
        if name in names:
            packed = np.ascontiguousarray(points[name]).view(np.uint32)
            return np.stack([(packed >> shift & 0xFF) for shift in (16, 8, 0)], axis=1).astype(np.uint8)
    return np.full((len(points), 3), NEUTRAL_GREY, dtype=np.uint8)
