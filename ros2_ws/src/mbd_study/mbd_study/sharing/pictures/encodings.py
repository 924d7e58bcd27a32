"""Pictures of a bag in their own encoding: looked at, and covered, raw and compressed alike."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from mbd_bag.errors import BagError
from mbd_bag.images.image_cdr import (
    COMPRESSED_IMAGE,
    CompressedImage,
    RawImage,
    read_compressed,
    read_image,
    write_compressed,
    write_image,
)
from mbd_model.errors import MbdError
from mbd_perception.frames.compressed_images import DEPTH_HEADER, DEPTH_MARK, decode_depth
from mbd_perception.frames.frame import FloatImage
from mbd_perception.frames.rvl import decode_rvl
from mbd_perception.segmentation.components import Mask
from numpy.typing import NDArray

GREY = 128  # of every byte of what is covered: mid-grey in every encoding below
Picture = RawImage | CompressedImage
# Bytes a pixel; how a grey picture is made of (height, width, bytes).
_CHANNELS = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "8UC1": 1, "8UC3": 3, "8UC4": 4}
_BRIGHTNESS = {"uyvy": 1, "yuv422": 1, "yuyv": 0, "yuv422_yuy2": 0}  # which byte of a pixel's two
_MOSAIC = {
    "bayer_rggb8": cv2.COLOR_BayerBG2GRAY,
    "bayer_bggr8": cv2.COLOR_BayerRG2GRAY,
    "bayer_gbrg8": cv2.COLOR_BayerGR2GRAY,
    "bayer_grbg8": cv2.COLOR_BayerGB2GRAY,
}
_DEPTHS = {"16UC1": "u2", "32FC1": "f4"}
_JPEG, _PNG = b"\xff\xd8", b"\x89PNG"
_QUALITY = [cv2.IMWRITE_JPEG_QUALITY, 95, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444]


def read_picture(message: bytes, msgtype: str) -> Picture:
    """An Image or CompressedImage of its CDR bytes; raises BagError when they are none."""
    return read_compressed(message) if msgtype == COMPRESSED_IMAGE else read_image(message)


def is_depth(picture: Picture) -> bool:
    """Whether it holds distances."""
    if isinstance(picture, RawImage):
        return picture.encoding in _DEPTHS
    return DEPTH_MARK in picture.format or picture.format.startswith(tuple(_DEPTHS))


def grey(picture: Picture) -> NDArray[np.uint8]:
    """A colour picture as (height, width) grey; raises BagError for an encoding that is not known."""
    if isinstance(picture, CompressedImage):
        pixels = _decoded(picture.data)
    elif picture.encoding in _MOSAIC:
        mosaic = np.ascontiguousarray(_pixels(picture, 1)[..., 0])
        if min(mosaic.shape) < 2:
            raise BagError(f"a mosaic of {picture.width}x{picture.height} pixels lacks a colour")
        return np.asarray(cv2.cvtColor(mosaic, _MOSAIC[picture.encoding]), np.uint8)
    elif picture.encoding in _BRIGHTNESS:
        return np.ascontiguousarray(_pixels(picture, 2)[..., _BRIGHTNESS[picture.encoding]])
    else:
        pixels = _pixels(picture, _bytes_of(picture))
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)
    if pixels.ndim == 2 or pixels.shape[2] < 3:
        return np.ascontiguousarray(pixels.reshape(*pixels.shape[:2], -1)[..., 0])
    return np.asarray(pixels[..., :3].mean(axis=2), np.uint8)  # whichever of them is red


def metres(picture: Picture) -> FloatImage:
    """A depth picture as (height, width) z [m], 0 = none; raises BagError when it cannot be read."""
    try:
        if isinstance(picture, CompressedImage):
            values: NDArray[Any] = decode_depth(picture.data, picture.format)
        else:
            kind = np.dtype(_DEPTHS[picture.encoding])
            order = kind.newbyteorder(">" if picture.bigendian else "<")
            values = np.ascontiguousarray(_pixels(picture, kind.itemsize)).view(order)[..., 0].astype(kind)
    except MbdError as error:
        raise BagError(str(error)) from error
    if values.dtype == np.uint16:
        return np.where(values == np.iinfo(np.uint16).max, 0, values).astype(np.float32) * np.float32(0.001)
    return np.where(np.isfinite(values) & (values > 0), values, 0).astype(np.float32)


def covered(picture: Picture, keep: Mask) -> bytes:
    """CDR bytes of the picture with all else covered: colour by grey, distances by none.

    Args:
        picture: colour or depth.
        keep: (height, width) bool.

    Raises:
        BagError: its encoding is not known, or it is of another size.
    """
    if isinstance(picture, CompressedImage):
        return _covered_file(picture, keep)
    _require_size((picture.height, picture.width), keep)
    depth = is_depth(picture)
    size = np.dtype(_DEPTHS[picture.encoding]).itemsize if depth else _bytes_of(picture)
    pixels = _pixels(picture, size).copy()
    if picture.encoding in _BRIGHTNESS:  # two pixels share their colour
        whole = keep.shape[1] // 2 * 2
        keep = keep.copy()
        keep[:, :whole] = np.repeat(keep[:, :whole].reshape(len(keep), -1, 2).all(axis=2), 2, axis=1)
    nothing = (np.frombuffer(np.float32(np.nan).tobytes(), np.uint8) if size == 4 else 0) if depth else GREY
    if depth and size == 4 and picture.bigendian:
        nothing = np.asarray(nothing)[::-1]
    pixels[~keep] = nothing
    # What a row holds behind its last pixel goes, too.
    data = memoryview(pixels.tobytes())
    return write_image(
        RawImage(
            picture.stamp,
            picture.frame_id,
            picture.height,
            picture.width,
            picture.encoding,
            picture.bigendian,
            picture.width * size,
            data,
        )
    )


def _covered_file(picture: CompressedImage, keep: Mask) -> bytes:
    """A compressed picture, covered and compressed again; distances become PNG, which loses nothing."""
    if not is_depth(picture):
        pixels = _decoded(picture.data).copy()
        _require_size(pixels.shape, keep)
        pixels[~keep] = GREY if pixels.dtype == np.uint8 else GREY << 8
        if bytes(picture.data[:2]) == _JPEG:
            _, encoded = cv2.imencode(".jpg", pixels, _QUALITY)
        elif bytes(picture.data[:4]) == _PNG:
            _, encoded = cv2.imencode(".png", pixels)
        else:
            raise BagError("compressed as neither JPEG nor PNG")
        return write_compressed(picture.stamp, picture.frame_id, picture.format, encoded.data)
    header = DEPTH_HEADER.size if DEPTH_MARK in picture.format else 0
    body = picture.data[header:]
    try:
        rvl = header and "rvl" in picture.format
        values = decode_rvl(body) if rvl else _decoded(body)
    except MbdError as error:
        raise BagError(str(error)) from error
    _require_size(values.shape, keep)
    _, encoded = cv2.imencode(".png", np.where(keep, values, 0).astype(values.dtype))
    form = picture.format.replace(" rvl", " png")
    return write_compressed(picture.stamp, picture.frame_id, form, bytes(picture.data[:header]) + encoded.tobytes())


def _require_size(shape: tuple[int, ...], keep: Mask) -> None:
    if shape[:2] != keep.shape:
        (height, width), (rows, columns) = shape[:2], keep.shape
        raise BagError(f"it has {width}x{height} pixels, its camera_info states {columns}x{rows}")


def _bytes_of(picture: RawImage) -> int:
    """Bytes of a pixel of colour; raises BagError for an encoding that is not known."""
    if picture.encoding in _MOSAIC:
        return 1
    if picture.encoding in _BRIGHTNESS:
        return 2
    if picture.encoding not in _CHANNELS:
        raise BagError(f"encoding '{picture.encoding}' cannot be covered")
    return _CHANNELS[picture.encoding]


def _pixels(picture: RawImage, size: int) -> NDArray[np.uint8]:
    """(height, width, bytes a pixel) view; raises BagError when there are too few bytes."""
    row = picture.width * size
    if row == 0 or picture.height == 0 or picture.step < row or len(picture.data) < picture.height * picture.step:
        raise BagError(f"a picture of {picture.width}x{picture.height} has {len(picture.data)} bytes: it is cut off")
    rows = np.frombuffer(picture.data, np.uint8, picture.height * picture.step).reshape(picture.height, picture.step)
    return rows[:, :row].reshape(picture.height, picture.width, size)


def _decoded(data: memoryview) -> NDArray[Any]:
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if len(data) else None
    except cv2.error as error:
        raise BagError(f"a compressed picture cannot be decoded ({error.err}): it is damaged") from error
    if pixels is None or pixels.dtype not in (np.uint8, np.uint16):
        raise BagError("a compressed picture cannot be decoded")
    return np.asarray(pixels)
