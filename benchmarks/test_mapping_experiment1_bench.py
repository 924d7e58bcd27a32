"""Experiment 1 complete, as its one command runs it: figures reached, and the time it takes.

The limit of 60 s on two cores is held against 120 s of CPU time: other programs of the machine do not count.
"""

from __future__ import annotations

import csv
import itertools
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from mbd_experiments.simulated_problems.experiment1_tool import main

LIMIT_CPU_S = 120.0


def test_experiment_1(benchmark: Callable[..., object], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Evidence solves twice what the rule solves after 2 assists, is calibrated, and survives exchanged assists."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.perf_counter()
    benchmark.pedantic(lambda: main(["--out", str(tmp_path), "--jobs", "2"]), rounds=1)
    wall = time.perf_counter() - begun
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    with (tmp_path / "shares.csv").open(newline="") as stream:
        within = {(r["size"], r["method"], r["assists"]): float(r["solved_within"]) for r in csv.DictReader(stream)}
    with (tmp_path / "calibration.csv").open(newline="") as stream:
        rows = {(r["method"], r["scenario"], r["size"], r["assists"]): r for r in csv.DictReader(stream)}
    with capsys.disabled():
        sys.stdout.write(f"\nexperiment 1: {wall:.0f} s with two processes, {cpu:.0f} s of CPU time\n")
        for size in ("5", "6", "7"):
            ratio = within[size, "evidence", "2"] / within[size, "mbd", "2"]
            errors = [float(rows["evidence", s, size, "-1"]["error"]) for s in ("clean", "one wrong in 40%")]
            sys.stdout.write(
                f"n = {size}: {ratio:.2f} x mbd after 2; calibration error {errors[0]:.3f}, {errors[1]:.3f}\n"
            )
    for size in ("6", "7"):
        assert within[size, "evidence", "2"] >= 2.0 * within[size, "mbd", "2"]
    for size in ("5", "6", "7"):
        help_given = [within[size, "evidence", str(k)] for k in range(int(size) + 1)]
        assert help_given == sorted(help_given)
        assert float(rows["evidence", "clean", size, "-1"]["error"]) <= 0.05
        assert float(rows["evidence", "one wrong in 40%", size, "-1"]["error"]) <= 0.05
        solved = [float(rows["evidence", "clean", size, str(k)]["solved"]) for k in range(int(size) + 1)]
        assert all(later >= earlier - 0.005 for earlier, later in itertools.pairwise(solved))
    exchanged = rows["evidence", "two exchanged in 40%", "6", "5"]
    assert float(exchanged["solved"]) >= 0.85
    assert cpu <= LIMIT_CPU_S
