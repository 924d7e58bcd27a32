"""Pairs of pieces behind an occluder, and whether they are one object: what the model that rejoins them learns from."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_perception.frames.files import load_frame
from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.joining.occlusion import PieceFeatures
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.rooms import Kind, random_room
from mbd_perception.tools.stages import stages_of

# Rooms that are learned from have numbers below the ones of the benchmark.
ROOMS_BELOW = 1000
# A piece belongs to the object that covers at least this share of it.
PURE = 0.7


@dataclass(frozen=True)
class PiecePair:
    """Two pieces of one scene.

    Attributes:
        scene: its name; pairs of one scene are never split between fitting and validation.
        features: what the model is given.
        same: whether they are one object.
    """

    scene: str
    features: PieceFeatures
    same: bool


def room_pairs(kinds: tuple[Kind, ...], rooms: int) -> Iterator[PiecePair]:
    """The pairs of rendered rooms of these kinds, ``rooms`` of each, at most ``ROOMS_BELOW``."""
    for kind in kinds:
        for number in range(min(rooms, ROOMS_BELOW)):
            room = random_room(kind, np.random.default_rng([zlib.crc32(kind.name.encode()), number]))
            yield from scene_pairs(f"{kind.name} {number}", room.view.frame, room.truth)


def folder_pairs(folder: Path) -> Iterator[PiecePair]:
    """The pairs of a labelled frame folder; in its labels.png 0 and 1 are no objects.

    Raises:
        MbdError: the folder is no frame, or its labels are missing.
    """
    frame = load_frame(folder)
    labels = cv2.imread(str(folder / "labels.png"), cv2.IMREAD_UNCHANGED)
    if labels is None or labels.shape != frame.depth.shape:
        raise MbdError(f"{folder / 'labels.png'} is missing or not of the size of depth.png: training needs the truth")
    yield from scene_pairs(folder.name, frame, np.where(labels > 1, labels, 0).astype(np.int32))


def scene_pairs(name: str, frame: RgbdFrame, truth: NDArray[np.int32]) -> Iterator[PiecePair]:
    """The pairs of one scene whose pieces are each of one true object; ``truth`` (height, width), 0 = none."""
    config = SegmentationConfig()
    found = segment(frame, None, config)
    pieces = stages_of(frame, found.plane, found.noise, config).parts.pieces
    if pieces is None:
        return
    small = truth[::2, ::2]
    owner: dict[int, int] = {}
    for group in np.unique(pieces.picture):
        count = np.bincount(small[pieces.picture == group])
        largest = int(count.argmax())
        if group and largest and count[largest] >= PURE * count.sum():
            owner[int(group)] = largest
    for first, second in pieces.candidates():
        if first in owner and second in owner:
            yield PiecePair(name, pieces.compare(first, second), owner[first] == owner[second])
