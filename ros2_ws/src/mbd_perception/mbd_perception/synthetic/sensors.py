"""What depth cameras make of a scene: noise, steps, shadows of the projector, holes, pixels between two surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.frame import DEPTH_NOISE, RgbdFrame, make_frame

Image = NDArray[np.float64]


@dataclass(frozen=True)
class Sensor:
    """A kind of depth camera.

    Attributes:
        noise: std of inverse depth [1/m]: of the disparity, for cameras that triangulate.
        blob: over how many pixels that noise is alike: matching windows smooth it.
        depth_noise: std of depth [m]: time of flight.
        disparity_step: inverse depth comes in steps of this [1/m]; 0 = none.
        baseline: distance of the projector to the right of the camera [m]; what it cannot reach has no depth.
        ragged: share of pixels missing within two pixels of a jump in depth.
        mixed: share of pixels at a jump that lie between the two surfaces.
        missing: share of pixels missing anywhere.
        bulge: depth is wrong by this share at the corners, less with the square of the distance from the middle.
    """

    noise: float = DEPTH_NOISE
    blob: float = 0.0
    depth_noise: float = 0.0
    disparity_step: float = 0.0
    baseline: float = 0.0
    ragged: float = 0.0
    mixed: float = 0.0
    missing: float = 0.0
    bulge: float = 0.0


# Structured light: Khoshelham & Elberink 2012; steps of an eighth of a pixel at 580 px and 75 mm.
KINECT_1 = Sensor(noise=1.5e-3, disparity_step=2.87e-3, baseline=0.075, ragged=0.3)
# Time of flight: a millimetre or two, no shadow, pixels between the surfaces.
KINECT_2 = Sensor(noise=0.0, depth_noise=1.5e-3, ragged=0.2, mixed=0.5, bulge=0.002)
# Stereo: an eighth of a pixel at 640 px and 50 mm, alike within the matching window.
REALSENSE = Sensor(noise=3.0e-3, blob=2.0, baseline=0.05, ragged=0.4, missing=0.02)


@dataclass(frozen=True)
class Optics:
    """The camera a frame states it was taken with, and when [s]."""

    camera: Intrinsics
    stamp: float


def sense(distance: Image, color: Image, optics: Optics, sensor: Sensor, rng: np.random.Generator) -> RgbdFrame:
    """A frame from true depth.

    Args:
        distance: (height, width) depth [m], inf where there is nothing.
        color: (height, width, 3) RGB.
        optics: camera and stamp of the frame.
        sensor: the kind of camera.
        rng: for everything random.
    """
    hit = np.isfinite(distance)
    w = np.where(hit, 1.0 / np.where(hit, distance, 1.0), 0.0)
    jump = _at_jumps(w)
    if sensor.baseline > 0:
        hit &= _lit(w, optics.camera.fx * sensor.baseline)
    if sensor.mixed > 0:
        between = jump & (rng.random(w.shape) < sensor.mixed)
        w = np.where(between, cv2.blur(w, (3, 3)), w)
    w = w * (1.0 + sensor.bulge * _from_the_middle(w.shape))
    disparity = w + _noise(w.shape, sensor, rng)
    if sensor.disparity_step > 0:
        disparity = np.rint(disparity / sensor.disparity_step) * sensor.disparity_step
    metres = np.where(hit & (disparity > 0.02), 1.0 / np.maximum(disparity, 0.02), 0.0)
    if sensor.depth_noise > 0:
        metres = np.where(metres > 0, np.maximum(metres + rng.normal(0.0, sensor.depth_noise, w.shape), 0.0), 0.0)
    if sensor.ragged > 0:
        near_jump = cv2.dilate(jump.view(np.uint8), np.ones((3, 3), np.uint8)).view(bool)
        metres[near_jump & (rng.random(w.shape) < sensor.ragged)] = 0.0
    if sensor.missing > 0:
        metres[rng.random(w.shape) < sensor.missing] = 0.0
    rgb8 = np.clip(color + rng.normal(0.0, 2.0, color.shape) * (color.sum(axis=2) > 0)[..., None], 0, 255)
    return make_frame(rgb8.astype(np.uint8), np.rint(1000.0 * metres).astype(np.uint16), optics.camera, optics.stamp)


def _noise(shape: tuple[int, ...], sensor: Sensor, rng: np.random.Generator) -> Image:
    """Noise of inverse depth [1/m]: independent, or alike over blobs."""
    raw = rng.normal(0.0, 1.0, shape)
    if sensor.blob > 0:
        raw = cv2.GaussianBlur(raw, (0, 0), sensor.blob)
        raw /= raw.std()
    return sensor.noise * raw


def _at_jumps(w: Image) -> NDArray[np.bool_]:
    """Pixels beside a jump in depth of more than 3 %."""
    window = np.ones((3, 3), np.uint8)
    low = cv2.erode(w, window)
    return np.asarray(cv2.dilate(w, window) > 1.03 * low)


def _lit(w: Image, focal_baseline: float) -> NDArray[np.bool_]:
    """What a projector to the right of the camera reaches: its columns must keep their order."""
    column = np.arange(w.shape[1]) - focal_baseline * w
    nearest_on_the_right = np.minimum.accumulate(column[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(column <= nearest_on_the_right + 0.5)


def _from_the_middle(shape: tuple[int, ...]) -> Image:
    """Square of the distance from the middle of the picture, 1 in the corners."""
    v, u = (np.linspace(-1.0, 1.0, n) for n in shape)
    return np.asarray(0.5 * (v[:, None] ** 2 + u[None] ** 2))
