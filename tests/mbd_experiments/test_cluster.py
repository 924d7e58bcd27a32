"""A real Dask scheduler with two workers on this machine: the same results as without, also when a worker is killed."""

from __future__ import annotations

import json
import math
import os
import signal
import socket
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import pytest
from mbd_experiments.simulated_problems.experiment1 import run_problem
from mbd_model.errors import MbdError
from mbd_model.parallel.cluster import DaskCluster
from mbd_model.parallel.executor import AHEAD, ItemError
from mbd_model.parallel.local_processes import LocalProcesses
from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_study.recompute.reevaluate_command import check_bags
from mbd_study.recompute.stages import RecomputeFrom

pytestmark = pytest.mark.system

distributed = pytest.importorskip(
    "distributed", reason="Dask is not installed: pip install -r requirements/cluster.txt"
)

PATIENCE = 60.0  # [s] for processes to start
# A second worker killed by an item is enough to give the item up.
SETTINGS = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
LOCAL = ("--host", "127.0.0.1", "--no-dashboard", "--dashboard-address", "127.0.0.1:0")


@dataclass
class Cluster:
    """A scheduler and its workers, each a process; ports are the system's choice."""

    folder: Path
    processes: list[subprocess.Popen[bytes]]
    address: str = ""
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self, kind: str, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *LOCAL, *words]
        with (self.folder / "log").open("a") as log:
            process = subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=log, env=os.environ | SETTINGS)
        self.processes.append(process)
        return process

    def start_workers(self, number: int) -> None:
        """Start as many as are missing, and wait for them."""
        words = (self.address, "--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder))
        working = [p for p in self.workers if p.poll() is None]
        self.workers = working + [self.start("worker", *words) for _ in range(number - len(working))]
        with distributed.Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(number, timeout=PATIENCE)


@contextmanager
def scheduler(folder: Path) -> Iterator[Cluster]:
    """A scheduler that has no workers yet; all of its processes are ended at the end."""
    made = Cluster(folder, [])
    file = folder / "scheduler.json"
    try:
        process = made.start("scheduler", "--port", "0", "--scheduler-file", str(file))
        deadline = time.monotonic() + PATIENCE
        while not made.address:
            assert process.poll() is None and time.monotonic() < deadline, (folder / "log").read_text()
            try:
                made.address = json.loads(file.read_text())["address"]
            except (OSError, ValueError):
                time.sleep(0.02)
        yield made
    finally:
        for process in made.processes:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with scheduler(tmp_path_factory.mktemp("cluster")) as made:
        yield made


@pytest.fixture
def dask(cluster: Cluster) -> DaskCluster:
    """With two workers, whatever the test before did to them."""
    cluster.start_workers(2)
    return DaskCluster(cluster.address)


def test_the_problems_of_experiment_1_give_the_same_in_the_same_order_for_every_executor(dask: DaskCluster):
    problems = [(4, 1), (3, 0), (4, 0), (3, 1)]
    solve = partial(run_problem, 5, 1)
    serial = list(LocalProcesses(1).run_all(solve, problems))
    assert list(dask.run_all(solve, problems)) == serial
    assert list(LocalProcesses(2).run_all(solve, problems)) == serial


def test_a_study_is_computed_again_there_as_by_one_process(dask: DaskCluster, made_bag: Path, tmp_path: Path):
    paths = [made_bag, tmp_path / "no_bag", made_bag]
    summaries = [
        [replace(summary, seconds=0.0) for summary in check_bags(paths, RecomputeFrom.ASSISTS, executor)]
        for executor in (dask, LocalProcesses(1))
    ]
    assert summaries[0] == summaries[1]
    assert [summary.agrees for summary in summaries[0]] == [True, False, True]


def test_no_more_items_are_taken_than_are_bounded_however_many_there_are(dask: DaskCluster):
    taken = 0

    def items() -> Iterator[int]:
        nonlocal taken
        for number in range(100):
            taken += 1
            yield number

    most = 0
    for given, _ in enumerate(dask.run_all(math.sqrt, items())):
        most = max(most, taken - given)
    assert taken == 100
    assert most <= AHEAD * 2


def test_an_error_names_the_item(dask: DaskCluster):
    results = dask.run_all(math.factorial, [3, -1], name=lambda n: f"number {n}")
    assert next(results) == 6
    with pytest.raises(ValueError, match="negative") as caught:
        next(results)
    assert any("number -1" in note for note in caught.value.__notes__)


def test_what_a_killed_worker_had_is_done_again_by_the_other(cluster: Cluster, dask: DaskCluster):
    items = [100_000 + k for k in range(6)]
    results = dask.run_all(math.factorial, items)
    first = next(results)
    killed = cluster.workers[0]
    killed.kill()
    assert [first, *results] == [math.factorial(n) for n in items]
    assert killed.wait(PATIENCE) == -signal.SIGKILL


def test_an_item_that_kills_every_worker_is_named(cluster: Cluster, dask: DaskCluster):
    with pytest.raises(ItemError, match="signal 9: the workers that tried it were killed"):
        list(dask.run_all(signal.raise_signal, [signal.SIGKILL], name=lambda s: f"signal {s}"))
    assert [worker.wait(PATIENCE) for worker in cluster.workers] == [-signal.SIGKILL] * 2


@pytest.mark.usefixtures("dask")
def test_the_option_leads_to_the_cluster(cluster: Cluster):
    parser = ArgumentParser()
    add_executor_options(parser, "numbers")
    executor = executor_of(parser.parse_args(["--scheduler", cluster.address]))
    assert list(executor.run_all(math.sqrt, [4.0, 9.0])) == [2.0, 3.0]


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1", ""])
def test_what_is_no_address_is_refused(address: str):
    with pytest.raises(MbdError, match="start one"):
        list(DaskCluster(address).run_all(math.sqrt, [1.0]))


def test_an_address_where_nobody_listens_is_refused():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(MbdError, match="no Dask scheduler answers"):
            list(DaskCluster(address).run_all(math.sqrt, [1.0]))


def test_without_dask_the_error_states_what_to_install(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MbdError, match=r"pip install -r requirements/cluster\.txt"):
        list(DaskCluster("tcp://127.0.0.1:1").run_all(math.sqrt, [1.0]))


def test_a_scheduler_without_workers_is_refused(tmp_path: Path):
    with scheduler(tmp_path) as alone, pytest.raises(MbdError, match="has no workers"):
        list(DaskCluster(alone.address).run_all(math.sqrt, [1.0]))


def test_a_scheduler_that_goes_away_is_named(tmp_path: Path):
    with scheduler(tmp_path) as alone:
        alone.start_workers(1)
        results = DaskCluster(alone.address).run_all(time.sleep, [0.0, 600.0])
        next(results)
        alone.processes[0].kill()
        with pytest.raises(MbdError, match="has gone"):
            next(results)
