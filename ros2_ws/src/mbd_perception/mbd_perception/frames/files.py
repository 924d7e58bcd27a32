"""Frames kept in files: a folder with color.png, depth.png (uint16) and meta.json (camera, depth_scale)."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from mbd_model.camera.intrinsics import CameraError, Intrinsics

from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame


def load_frame(folder: Path) -> RgbdFrame:
    """A frame from a folder; its stamp is 0.

    Raises:
        FrameError: a file is missing or not what it should be; the text names it.
    """
    color = _picture(folder / "color.png", cv2.IMREAD_COLOR)
    depth = _picture(folder / "depth.png", cv2.IMREAD_UNCHANGED)
    if depth.dtype != np.uint16:
        raise FrameError(f"{folder / 'depth.png'} has {depth.dtype} pixels, expected uint16 millimetres")
    meta = folder / "meta.json"
    return make_frame(
        np.ascontiguousarray(color[..., ::-1]), depth, load_camera(meta), depth_scale=load_depth_scale(meta)
    )


def load_camera(path: Path) -> Intrinsics:
    """The camera of a meta.json; raises FrameError naming file and key."""
    camera = _meta(path)["camera"]
    values = {key: _number(path, key, camera.get(key)) for key in ("fx", "fy", "cx", "cy", "width", "height")}
    sides = {key: int(values.pop(key)) for key in ("width", "height")}
    try:
        return Intrinsics(**values, width=sides["width"], height=sides["height"])
    except CameraError as error:
        raise FrameError(f"{path}: {error}") from error


def load_depth_scale(path: Path) -> float:
    """Metres per unit of depth.png: ``depth_scale``, in ``camera`` or beside it, of a meta.json; 0.001 without it.

    Raises:
        FrameError: it is no positive number; the text names the file.
    """
    meta = _meta(path)
    value = meta["camera"].get("depth_scale", meta.get("depth_scale", 0.001))
    if isinstance(value, bool) or not isinstance(value, int | float) or not 1e-6 <= value <= 1.0:
        raise FrameError(
            f"{path}: depth_scale {value!r} is not the metres of one unit of depth.png; 0.001 stands for millimetres"
        )
    return float(value)


def _meta(path: Path) -> dict[str, Any]:
    """The object in a meta.json, which has one called camera; raises FrameError naming the file."""
    try:
        meta: Any = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise FrameError(
            f"{path}: cannot be read ({error.strerror}); a frame folder needs it for the camera"
        ) from error
    except (ValueError, RecursionError) as error:
        raise FrameError(f"{path} is no JSON in UTF-8: {error}") from error
    if not isinstance(meta, dict) or not isinstance(meta.get("camera"), dict):
        raise FrameError(f'{path}: expected {{"camera": {{"fx": …}}}} with fx, fy, cx, cy, width, height')
    return meta


def _number(path: Path, key: str, value: object) -> float:
    """A finite number of the camera in a meta.json; raises FrameError naming file and key."""
    if value is None:
        raise FrameError(f"{path}: camera.{key!r} is missing; it needs fx, fy, cx, cy, width, height")
    try:
        number = float(value)  # type: ignore[arg-type]  # text of a number will do, anything else is told
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if isinstance(value, bool) or not math.isfinite(number):
        raise FrameError(f"{path}: camera.{key} is {str(value)[:40]!r}, expected a number of pixels")
    return number


def _picture(path: Path, flags: int) -> Any:
    """An image file as an array; raises FrameError naming it."""
    if not path.is_file():
        raise FrameError(f"{path} is missing: a frame folder holds color.png, depth.png and meta.json")
    picture = cv2.imread(str(path), flags)
    if picture is None:
        raise FrameError(f"{path} is no picture that can be read; write it again as PNG")
    return picture
