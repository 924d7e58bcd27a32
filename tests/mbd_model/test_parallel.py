"""Many items by processes of this machine: the same as one after the other, also when processes are killed."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import suppress
from functools import partial

import pytest
from mbd_model.camera.pose import pose_from_quaternion
from mbd_model.errors import MbdError
from mbd_model.parallel.executor import AHEAD, ItemError
from mbd_model.parallel.local_processes import LocalProcesses
from mbd_model.parallel.options import add_executor_options, executor_of

TWO = LocalProcesses(2)


@pytest.mark.parametrize("jobs", [1, 2, 3])
def test_results_come_in_the_order_of_the_items_for_any_number_of_processes(jobs: int):
    items = [300, 0, 200, 1, 100, 2]
    assert list(LocalProcesses(jobs).run_all(math.factorial, items)) == [math.factorial(n) for n in items]


def test_no_items_give_no_results():
    assert list(TWO.run_all(math.factorial, [])) == []


@pytest.mark.parametrize("jobs", [1, 2])
def test_no_more_items_are_taken_than_are_bounded_however_many_there_are(jobs: int):
    taken = 0

    def items() -> Iterator[int]:
        nonlocal taken
        for number in range(100):
            taken += 1
            yield number

    most = 0
    for given, _ in enumerate(LocalProcesses(jobs).run_all(math.sqrt, items())):
        most = max(most, taken - given)
    assert taken == 100
    assert most <= AHEAD * jobs


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_comes_at_its_turn_and_names_the_item(jobs: int):
    results = LocalProcesses(jobs).run_all(math.factorial, [3, 4, -1, 5], name=lambda n: f"number {n}")
    assert [next(results), next(results)] == [6, 24]
    with pytest.raises(ValueError, match="negative") as caught:
        next(results)
    assert any("number -1" in note for note in caught.value.__notes__)


@pytest.mark.parametrize("jobs", [1, 2])
def test_input_that_cannot_be_used_is_an_error_that_names_the_item(jobs: int):
    function = partial(pose_from_quaternion, (0.0, 0.0, 0.0))
    with pytest.raises(ItemError, match=r"^camera 2: ") as caught:
        list(LocalProcesses(jobs).run_all(function, [(0.0, 0.0, 0.0, 0.0)], name=lambda _: "camera 2"))
    assert isinstance(caught.value.__cause__, MbdError)


def test_a_result_that_cannot_be_sent_is_an_error_that_names_the_item():
    with pytest.raises(TypeError, match="pickle") as caught:
        list(TWO.run_all(memoryview, [b"picture"], name=lambda _: "picture 7"))
    assert any("picture 7" in note for note in caught.value.__notes__)


def test_what_a_killed_process_had_is_done_again():
    before = set(multiprocessing.active_children())
    results = TWO.run_all(math.factorial, [3, 100_000, 100_000, 4])
    assert next(results) == 6
    processes = set(multiprocessing.active_children()) - before
    assert len(processes) == 2
    for process in processes:
        process.kill()
    assert list(results) == [math.factorial(100_000), math.factorial(100_000), 24]
    assert {process.exitcode for process in processes} == {-signal.SIGKILL}


def test_an_item_whose_process_is_killed_twice_is_named_and_the_results_before_it_are_given():
    results = TWO.run_all(signal.raise_signal, [0, signal.SIGKILL, 0], name=lambda s: f"signal {s}")
    assert next(results) is None
    with pytest.raises(ItemError, match=rf"signal {signal.SIGKILL}: its process was ended by SIGKILL"):
        next(results)


def test_nothing_is_left_running_when_nobody_wants_the_rest():
    before = set(multiprocessing.active_children())
    results = TWO.run_all(time.sleep, [0.0, 600.0, 600.0])
    next(results)
    assert set(multiprocessing.active_children()) - before
    results.close()
    assert set(multiprocessing.active_children()) == before


@pytest.fixture
def leader() -> Iterator[subprocess.Popen[str]]:
    """A command at work by two processes, each with an item of ten minutes, in a group of its own."""
    code = """
import signal, time
from mbd_model.parallel.local_processes import LocalProcesses
signal.signal(signal.SIGINT, signal.default_int_handler)
results = LocalProcesses(2).run_all(time.sleep, [0.0, 600.0, 600.0])
next(results)
print("at work", flush=True)
next(results)
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "at work\n"
    yield process
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def test_control_c_ends_it_at_once_and_leaves_no_process(leader: subprocess.Popen[str]):
    # A terminal sends it to every process of the group.
    os.killpg(leader.pid, signal.SIGINT)
    # The pipes end when the last process that holds them does.
    _, errors = leader.communicate(timeout=20.0)
    assert errors.count("Traceback") == 1, errors
    assert errors.rstrip().endswith("KeyboardInterrupt")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_command_that_is_ended_alone_leaves_no_process(leader: subprocess.Popen[str], number: signal.Signals):
    leader.send_signal(number)
    leader.communicate(timeout=20.0)
    assert leader.returncode == -number


def test_no_processes_cannot_compute():
    with pytest.raises(MbdError, match="0 processes"):
        LocalProcesses(0)


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["--jobs", "0"], "1 or more"),
        (["--jobs", "two"], "1 or more"),
        (["--jobs", "2", "--scheduler", "x"], "not allowed"),
    ],
)
def test_options_without_meaning_are_refused(words: list[str], wanted: str, capsys: pytest.CaptureFixture[str]):
    parser = ArgumentParser()
    add_executor_options(parser, "sessions")
    with pytest.raises(SystemExit):
        parser.parse_args(words)
    assert wanted in capsys.readouterr().err


def test_the_options_choose_the_executor():
    parser = ArgumentParser()
    add_executor_options(parser, "sessions")
    assert str(executor_of(parser.parse_args(["--jobs", "7"]))) == "7 processes"
    assert str(executor_of(parser.parse_args(["--jobs", "7"]), most_jobs=2)) == "2 processes"
    assert str(executor_of(parser.parse_args(["--scheduler", "tcp://h:1"]), most_jobs=2)) == "Dask cluster tcp://h:1"
