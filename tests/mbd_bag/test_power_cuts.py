"""What a simulated power cut is said to cost is what a reader finds missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mbd_bag.recorder.power_cuts import after_cut, power_cuts
from mbd_bag.storage.bag import Bag


def test_what_a_cut_leaves_reads_up_to_the_moment_that_is_stated(tmp_path: Path):
    # Files so small that cuts fall into several of them.
    cuts = power_cuts(tmp_path / "bag", 12, 5.0, np.random.default_rng(1), picture=40_000, file_size=2_000_000)
    assert len({cut.file for cut in cuts}) > 1
    counts = []
    for number, cut in enumerate(cuts[::3]):
        found = [m.log_time for m in Bag(after_cut(cut, tmp_path / f"cut_{number}")).messages()]
        assert cut.moment - max(found) == pytest.approx(cut.loss * 1e9, abs=1e3)
        counts.append(len(found))
    assert counts == sorted(counts)
    assert counts[0] < counts[-1] <= len(list(Bag(tmp_path / "bag").messages()))
