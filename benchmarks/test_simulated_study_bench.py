"""Simulated participants: how much faster than real time a session is, and what that makes of a study of 30."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_share_directory
from mbd_experiments.simulated_participants.error_model import intentions
from mbd_experiments.simulated_participants.study import run_study
from mbd_model.parallel.local_processes import LocalProcesses
from pytest_benchmark.fixture import BenchmarkFixture

PARTICIPANTS, SESSIONS = 10, 30
LIMIT = 30 * 60.0  # [s] for the complete study on 2 cores


@pytest.mark.benchmark(group="simulated participants")
@pytest.mark.timeout(1200)
def test_a_simulated_study_is_faster_than_real_time(tmp_path: Path, benchmark: BenchmarkFixture):
    """Two participants, every task, through rendered RGB-D; as many sessions at a time as there are cores."""
    scenes = Path(get_package_share_directory("mbd_cell")) / "config"
    knowledge = Path(get_package_share_directory("mbd_perception")) / "config" / "knowledge.yaml"
    some = [i for i in intentions(PARTICIPANTS, 1) if i.participant in ("p1", "p2")]
    jobs = os.cpu_count() or 1

    def simulate() -> float:
        results = run_study(some, tmp_path, executor=LocalProcesses(jobs), scenes=scenes, knowledge=knowledge)
        done = [result for _, result in results]
        assert not [r for r in done if isinstance(r, str)], done
        return sum(r.simulated for r in done)

    begun = time.perf_counter()
    simulated = benchmark.pedantic(simulate, rounds=1)
    took = time.perf_counter() - begun
    study = took * SESSIONS / len(some)
    benchmark.extra_info |= {"times_real_time": simulated / took, "study_s": study}
    print(
        f"\n{len(some)} sessions of {simulated:.0f} s in {took:.0f} s on {jobs} cores: "
        f"{simulated / took:.1f} x real time; the study of {SESSIONS} in {study / 60:.0f} min"
    )
    assert simulated > took
    assert study <= LIMIT
