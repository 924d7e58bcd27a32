"""How often flush boxes of two colours come apart, and what is printed is cut: MBD_PAIRS of each (default 10)."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.casting import Solid
from mbd_perception.synthetic.paint import Paint, Pattern
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render
from mbd_perception.synthetic.rooms import PALETTE

PAIRS = int(os.environ.get("MBD_PAIRS", "10"))


class Draw:
    """Random sizes, place, turn and four different colours."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.colors = [PALETTE[k] for k in rng.choice(len(PALETTE), 4, replace=False)]
        self.yaw = float(rng.uniform(-1.2, 1.2))
        self.width, self.depth, self.height = rng.uniform(0.05, 0.14, 3).tolist()
        self.y = float(rng.uniform(-0.15, 0.15))

    def box(self, across: float, z: float, height: float, color: int, paint: Paint | None = None) -> Box:
        """A box ``across`` [m] from the middle along its own width."""
        x, y = 0.6 - np.sin(self.yaw) * across, self.y + np.cos(self.yaw) * across
        return Box((x, y, z), (self.depth, self.width, height), self.colors[color], self.yaw, paint)


def beside(d: Draw, share: float = 1.0) -> list[Solid]:
    """Two boxes side by side, the second of that share of the first's height."""
    return [d.box(-d.width / 2, 0.0, d.height, 0), d.box(d.width / 2, 0.0, share * d.height, 1)]


CASES: dict[str, Callable[[Draw], list[Solid]]] = {
    "two boxes side by side": beside,
    "two boxes side by side, one lower": lambda d: beside(d, 0.7),
    "two boxes, one on the other": lambda d: [d.box(0.0, 0.0, d.height, 0), d.box(0.0, d.height, 0.8 * d.height, 1)],
    "one tin of two colours": lambda d: [
        Cylinder((0.6, d.y, z), 0.04, 0.06, c) for z, c in ((0.0, d.colors[0]), (0.06, d.colors[1]))
    ],
} | {
    f"one box with {p.value}": lambda d, p=p: [d.box(0.0, 0.0, d.height, 0, Paint(p, tuple(d.colors[1:3]), 7))]
    for p in Pattern
}


@pytest.mark.parametrize("name", CASES)
def test_seams(benchmark: Any, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """How many are found as two objects, or more."""
    cut = 0

    def everything() -> None:
        nonlocal cut
        for seed in range(PAIRS):
            rng = np.random.default_rng([seed, 11])
            solids = CASES[name](Draw(rng))
            eye = (rng.uniform(-0.3, 0.0), rng.uniform(-0.3, 0.3), rng.uniform(0.5, 0.9))
            view = render(solids, looking_at(eye, (0.65, 0.0, 0.05)), rng, noise=2e-3)
            cut += segment(view.frame, None, SegmentationConfig()).count > 1

    benchmark.pedantic(everything, rounds=1, iterations=1)
    with capsys.disabled():
        print(f"\n{name}: {cut} of {PAIRS} come apart")
