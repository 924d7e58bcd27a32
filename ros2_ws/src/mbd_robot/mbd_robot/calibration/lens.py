"""The lens that the pictures were taken with: pinhole and distortion, as camera_info and calibration files state it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_robot.calibration.errors import CalibrationError

MODELS = ("plumb_bob", "rational_polynomial", "")


@dataclass(frozen=True)
class CalibratedLens:
    """A camera's lens.

    Attributes:
        pinhole: focal lengths, principal point, picture size [px].
        distortion: OpenCV's coefficients (k1, k2, p1, p2, k3, ...); () for none.
        origin: where these numbers come from, for people.
    """

    pinhole: Intrinsics
    distortion: tuple[float, ...] = ()
    origin: str = ""

    @property
    def matrix(self) -> NDArray[np.float64]:
        """(3, 3) camera matrix K [px]."""
        p = self.pinhole
        return np.array([[p.fx, 0.0, p.cx], [0.0, p.fy, p.cy], [0.0, 0.0, 1.0]])

    def undistorted(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 2) pixels [px] as a lens without distortion would show them."""
        if not any(self.distortion) or len(pixels) == 0:
            return np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
        k = self.matrix
        moved = cv2.undistortPoints(pixels.reshape(-1, 1, 2).astype(np.float64), k, np.array(self.distortion), P=k)
        return np.asarray(moved, dtype=np.float64).reshape(-1, 2)

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) pixels [px], without distortion, of points (..., 3) [m, optical frame]; NaN behind the camera."""
        p = self.pinhole
        depth = np.where(points[..., 2] > 1e-6, points[..., 2], np.nan)
        return np.stack((p.fx * points[..., 0] / depth + p.cx, p.fy * points[..., 1] / depth + p.cy), axis=-1)


def lens_of(
    matrix: Sequence[float], size: tuple[int, int], distortion: Sequence[float], model: str, origin: str
) -> CalibratedLens:
    """A lens as messages and files state it.

    Args:
        matrix: nine numbers of K, row by row [px].
        size: (width, height) [px].
        distortion: coefficients; empty for none.
        model: plumb_bob, rational_polynomial, or "" where none is named.
        origin: where it was read, for people and errors.

    Raises:
        CalibrationError: another model than OpenCV's, or numbers that are no lens.
    """
    if model not in MODELS and any(distortion):
        raise CalibrationError(f"{origin}: distortion model '{model}'; expected plumb_bob or rational_polynomial")
    if len(matrix) != 9:
        raise CalibrationError(f"{origin}: the camera matrix has {len(matrix)} numbers; expected 9, row by row")
    k = [float(v) for v in matrix]
    pinhole = Intrinsics(k[0], k[4], k[2], k[5], width=int(size[0]), height=int(size[1]))
    if any(distortion) and len(distortion) not in (4, 5, 8, 12, 14):
        raise CalibrationError(f"{origin}: {len(distortion)} coefficients of distortion; expected 4, 5, 8, 12 or 14")
    return CalibratedLens(pinhole, tuple(float(v) for v in distortion) if any(distortion) else (), origin)


def read_lens(file: Path) -> CalibratedLens:
    """The lens in a YAML file: camera_calibration's own format, or a camera_info as ``ros2 topic echo`` prints it.

    Raises:
        CalibrationError: no such file, or none of the two; says which key is missing.
    """
    try:
        held = next(iter(yaml.safe_load_all(file.read_text(encoding="utf-8"))), None)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise CalibrationError(f"the lens {file} cannot be read: {error}") from error
    if not isinstance(held, Mapping):
        raise CalibrationError(f"the lens {file} holds no keys; expected image_width, camera_matrix, ...")
    try:
        size = (int(_first(held, "image_width", "width")), int(_first(held, "image_height", "height")))
        matrix = _numbers(_first(held, "camera_matrix", "k", "K"))
        distortion = _numbers(held.get("distortion_coefficients", held.get("d", held.get("D", []))))
    except KeyError as error:
        raise CalibrationError(
            f"the lens {file} lacks {error}; expected the output of camera_calibration, or of "
            "`ros2 topic echo --once TOPIC/camera_info`"
        ) from error
    except (TypeError, ValueError) as error:
        raise CalibrationError(f"the lens {file} cannot be understood: {error}") from error
    return lens_of(matrix, size, distortion, str(held.get("distortion_model", "")), str(file))


def _first(held: Mapping[str, Any], *names: str) -> Any:
    for name in names:
        if name in held:
            return held[name]
    raise KeyError(" or ".join(names))


def _numbers(value: Any) -> list[float]:
    """Numbers of a list, or of the ``data`` of camera_calibration's matrices."""
    return [float(v) for v in (value["data"] if isinstance(value, Mapping) else value)]
