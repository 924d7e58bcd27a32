"""How well perception does in random rooms of every kind: a table. They are synthetic, and their truth is known.

`python -m pytest benchmarks/test_perception_rooms.py --benchmark-only` (part of `make bench`); MBD_ROOMS rooms of each
kind (default 8). The seeds are others than those the method was developed on.
"""

from __future__ import annotations

import os
import zlib
from typing import Any

import numpy as np
import pytest
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.rooms import Kind, random_room
from mbd_perception.synthetic.scoring import Score, score

ROOMS = int(os.environ.get("MBD_ROOMS", "8"))
FRESH = 1000


def scored(kind: Kind, number: int) -> Score:
    """How well one room is segmented without knowing the camera's pose."""
    room = random_room(kind, np.random.default_rng([zlib.crc32(kind.name.encode()), FRESH + number]))
    return score(segment(room.view.frame, None, SegmentationConfig()).labels, room.truth, room.valid)


@pytest.mark.parametrize("kind", list(Kind), ids=lambda k: k.name)
def test_rooms(benchmark: Any, kind: Kind, capsys: pytest.CaptureFixture[str]) -> None:
    """A kind of room: mean weighted overlap, share of right counts, false objects."""
    results: list[Score] = []

    def everything() -> None:
        results[:] = [scored(kind, number) for number in range(ROOMS)]

    benchmark.pedantic(everything, rounds=1, iterations=1)
    overlap = np.mean([s.weighted_overlap for s in results])
    right, false = sum(s.right_count for s in results), sum(s.false_objects for s in results)
    with capsys.disabled():
        print(f"\n| {kind.value} | {overlap:.3f} | {right} of {ROOMS} | {false} |")
