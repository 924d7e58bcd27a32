"""Computing many sessions again on all cores: how time and memory grow with their number.

The sessions are those of bags/, each many times over. From assists, and a few from RGB-D, against real time.
"""

from __future__ import annotations

import os
import resource
import time
from pathlib import Path

import pytest
from mbd_model.parallel.local_processes import LocalProcesses
from mbd_study.recompute.reevaluate_command import check_bags, useful_jobs
from mbd_study.recompute.stages import RecomputeFrom
from pytest_benchmark.fixture import BenchmarkFixture

SAMPLES = sorted(p.parent for p in (Path(__file__).resolve().parents[1] / "bags").glob("*/metadata.yaml"))
JOBS = os.cpu_count() or 1


def computed(number: int, stage: RecomputeFrom) -> tuple[int, float]:
    """How many sessions gave estimates, and the seconds that were recorded in all."""
    paths = (SAMPLES[k % len(SAMPLES)] for k in range(number))
    done, seconds = 0, 0.0
    for summary in check_bags(paths, stage, LocalProcesses(min(JOBS, useful_jobs(number, stage)))):
        assert not summary.failure, summary.failure
        done += summary.estimates > 0
        seconds += summary.recorded_seconds
    return done, seconds


def megabytes(who: int) -> float:
    return resource.getrusage(who).ru_maxrss / 1024


@pytest.mark.skipif(not SAMPLES, reason="bags/ is empty: tools/record_sample_bags")
@pytest.mark.benchmark(group="sessions computed again from assists")
@pytest.mark.timeout(900)
@pytest.mark.parametrize("number", [30, 100, 1000])
def test_sessions_from_assists(number: int, benchmark: BenchmarkFixture):
    begun = time.perf_counter()
    done, _ = benchmark.pedantic(computed, (number, RecomputeFrom.ASSISTS), rounds=1)
    took = time.perf_counter() - begun
    workers = megabytes(resource.RUSAGE_CHILDREN)
    benchmark.extra_info |= {"sessions_per_s": number / took, "worker_MB": workers}
    print(
        f"\n{number:5} sessions from assists: {took:6.1f} s, {1e3 * took / number:5.1f} ms each on {JOBS} cores; "
        f"at most {megabytes(resource.RUSAGE_SELF):.0f} MB here and {workers:.0f} MB in a worker"
    )
    assert done == number
    if number == 30:
        assert took <= 5.0


@pytest.mark.skipif(not SAMPLES, reason="bags/ is empty: tools/record_sample_bags")
@pytest.mark.benchmark(group="sessions computed again from RGB-D")
def test_sessions_from_rgbd_are_20_times_faster_than_they_were(benchmark: BenchmarkFixture):
    begun = time.perf_counter()
    _, seconds = benchmark.pedantic(computed, (12, RecomputeFrom.CLOUDS), rounds=1)
    took = time.perf_counter() - begun
    print(f"\n   12 sessions from RGB-D: {took:6.1f} s for {seconds:.0f} s recorded: {seconds / took:.0f} x real time")
    assert seconds >= 20.0 * took
