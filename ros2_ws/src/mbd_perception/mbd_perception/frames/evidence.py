"""A frame on which perception failed in a way nobody expected, kept for whoever looks into it."""

from __future__ import annotations

import json
import traceback
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np

from mbd_perception.frames.frame import RgbdFrame

# So many are kept: a camera delivers thirty a second.
MOST = 5


def keep_evidence(
    folder: Path, error: Exception, frame: RgbdFrame | None, raw: Mapping[str, bytes] | None = None
) -> Path | None:
    """Write the frame as a frame folder of its own below ``folder``, with the traceback as error.txt.

    Args:
        folder: made where it is missing.
        error: what happened.
        frame: None when there was none yet.
        raw: contents of further files by name: what the frame was to be made of.

    Returns:
        The new folder; None when ``MOST`` are there already, or nothing can be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        taken = {path.name for path in folder.iterdir()}
        name = next((n for k in range(1, MOST + 1) if (n := f"frame_{k}") not in taken), None)
        if name is None:
            return None
        own = folder / name
        own.mkdir()
        text = "".join(traceback.format_exception(error))
        (own / "error.txt").write_text(text, encoding="utf-8")
        for file, content in (raw or {}).items():
            (own / file).write_bytes(content)
        if frame is not None:
            save_frame(own, frame)
    except (OSError, cv2.error):
        return None
    return own


def save_frame(folder: Path, frame: RgbdFrame) -> None:
    """Write color.png, depth.png (millimetres) and meta.json, as ``load_frame`` reads them."""
    cv2.imwrite(str(folder / "color.png"), np.ascontiguousarray(frame.color[..., ::-1]))
    depth = np.clip(np.rint(frame.depth * 1000.0), 0, 65534).astype(np.uint16)
    cv2.imwrite(str(folder / "depth.png"), depth)
    camera = frame.camera
    optics = {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy}
    meta = {"camera": {**optics, "width": camera.width, "height": camera.height}, "stamp": frame.stamp}
    (folder / "meta.json").write_text(json.dumps(meta, indent=1) + "\n", encoding="utf-8")
