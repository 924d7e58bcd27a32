"""How exactly features are measured, by set: median and 90 % quantile of each error, and whether what is stated holds.

`python -m pytest benchmarks/test_perception_features.py --benchmark-only` (part of `make bench`): the labelled frames
of ../shared/rgbd, split as docs/perception.md says, and MBD_ROOMS rendered rooms of each kind (default 2) that nothing
was fitted to.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from mbd_experiments.perception_training.feature_errors import FeatureError, folder_errors
from mbd_experiments.perception_training.feature_errors_command import (
    APART,
    all_room_errors,
    coverage_table,
    error_table,
)
from mbd_model.parallel.local_processes import LocalProcesses
from mbd_perception.features.deviation_weights import WEIGHTS

ROOMS = int(os.environ.get("MBD_ROOMS", "2"))
FOLDER = Path(__file__).resolve().parents[2] / "shared/rgbd"
FIRST = (0, 3, *range(12, 18), 21, 25, 33, 34, 35, 37, 38, 39, 40, 43, 44)


def frames() -> dict[str, list[Path]]:
    """The real frames by set; none where ../shared/rgbd is absent."""
    every = sorted(FOLDER.glob("mosd_*"))
    first = [f for f in every if f.name in {f"mosd_learn{k}" for k in FIRST}]
    others = [f for f in every if f not in first]
    return {"first": first, "choose": others[::2], "report": others[1::2]} if every else {}


def test_features(benchmark: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """A table of errors by set, and one of coverage for each set."""
    sets: dict[str, list[FeatureError]] = {}

    def everything() -> None:
        for name, folders in frames().items():
            sets[name] = [error for folder in folders for error in folder_errors(folder)]
        sets["rooms"] = all_room_errors(LocalProcesses(1), APART, ROOMS)

    benchmark.pedantic(everything, rounds=1, iterations=1)
    with capsys.disabled():
        print("\n" + "\n".join(error_table(sets)))
        for name, errors in sets.items():
            print("\n".join(("", f"{name}:", "", *coverage_table(errors, WEIGHTS))))
