"""Processes of this machine, one item each at a time, so that a process that is killed names the item it had."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from mbd_model.errors import MbdError
from mbd_model.parallel.executor import AHEAD, Item, ItemError, Result, raise_named

TRIES = 2  # a killed process's item is done again once: it may have been killed for no fault of the item

# Forked processes would share this one's GL and thread state.
_CONTEXT = get_context("spawn")


@dataclass(frozen=True)
class _Failure:
    """What a function raised, and where."""

    error: Exception
    trace: str


@dataclass(frozen=True)
class _Task:
    """An item on its way: its place in the order, the item, and which try this is (1, 2)."""

    place: int
    item: Any
    attempt: int = 1


class LocalProcesses:
    """As many processes of this machine as ``jobs``; 1 computes in this process.

    Raises:
        MbdError: ``jobs`` is less than 1.
    """

    def __init__(self, jobs: int) -> None:
        if jobs < 1:
            raise MbdError(f"{jobs} processes cannot compute anything: give 1 or more")
        self.jobs = jobs

    def __str__(self) -> str:
        return "1 process" if self.jobs == 1 else f"{self.jobs} processes"

    def run_all(
        self, function: Callable[[Item], Result], items: Iterable[Item], name: Callable[[Item], str] = str
    ) -> Iterator[Result]:
        """See `Executor.run_all`; the same results in the same order for any number of processes."""
        if self.jobs == 1:
            yield from _here(function, items, name)
            return
        workers: list[_Worker] = []
        try:
            yield from self._by(workers, function, items, name)
        finally:
            # Also on Ctrl-C, an error, or when nobody wants the rest.
            for worker in workers:
                worker.end()

    def _by(
        self,
        workers: list[_Worker],
        function: Callable[[Item], Result],
        items: Iterable[Item],
        name: Callable[[Item], str],
    ) -> Iterator[Result]:
        waiting = (_Task(place, item) for place, item in enumerate(items))
        done: dict[int, tuple[Item, Any]] = {}
        expected = taken = 0
        exhausted = False
        while True:
            while not exhausted and taken - expected < AHEAD * self.jobs and _free(workers, self.jobs):
                task = next(waiting, None)
                if task is None:
                    exhausted = True
                    break
                taken += 1
                _hand_over(workers, task, function)
            if expected in done:
                item, value = done.pop(expected)
                expected += 1
                if isinstance(value, _Failure):
                    raise_named(value.error, name(item), value.trace)
                yield value
                continue
            busy = [worker for worker in workers if worker.task is not None]
            if not busy:
                return
            for worker in _ready_workers(busy):
                task, value = worker.result()
                if not isinstance(value, _Killed):
                    done[task.place] = task.item, value
                    continue
                workers.remove(worker)
                if task.attempt < TRIES:
                    _hand_over(workers, _Task(task.place, task.item, task.attempt + 1), function)
                    continue
                error = ItemError(f"{name(task.item)}: its process {value.how}, and so did the one that tried again")
                done[task.place] = task.item, _Failure(error, "")


HERE = LocalProcesses(1)  # one item after the other, in this process


@dataclass(frozen=True)
class _Killed:
    """A process that ended without an answer, and how."""

    how: str


class _Worker:
    """One process and the item it has.

    Attributes:
        connection: to it; readable when it answers or ends.
        task: it works at; None when it is free.
    """

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self.connection, theirs = _CONTEXT.Pipe()
        self.task: _Task | None = None
        self._process = _CONTEXT.Process(target=_serve, args=(theirs, function), daemon=True)
        _start_deaf(self._process)
        # The process holds the only other end now: when it ends, this one reads the end of file.
        theirs.close()

    def take(self, task: _Task) -> None:
        """Begin with an item."""
        self.task = task
        # One that was killed while it was free reports it when its answer is read.
        with suppress(BrokenPipeError):
            self.connection.send(task.item)

    def result(self) -> tuple[_Task, Any]:
        """The task and its answer: a result, a _Failure, or _Killed; waits for it."""
        task, self.task = self.task, None
        if task is None:
            raise ValueError("a worker without a task has no result")
        try:
            return task, pickle.loads(self.connection.recv_bytes())
        except (EOFError, ConnectionResetError):
            self._process.join()
            self.connection.close()
            return task, _Killed(_ending(self._process.exitcode))

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self.connection.close()
        if self.task is not None:
            self._process.kill()
        self._process.join()


def _free(workers: list[_Worker], jobs: int) -> bool:
    return len(workers) < jobs or any(worker.task is None for worker in workers)


def _hand_over(workers: list[_Worker], task: _Task, function: Callable[[Any], Any]) -> None:
    """Give the task to a free worker, or to a new one."""
    worker = next((worker for worker in workers if worker.task is None), None)
    if worker is None:
        worker = _Worker(function)
        workers.append(worker)
    worker.take(task)


def _ready_workers(busy: list[_Worker]) -> list[_Worker]:
    """The workers that answered or ended, at least one; waits for it."""
    ready = wait([worker.connection for worker in busy])
    return [worker for worker in busy if worker.connection in ready]


def _here(function: Callable[[Item], Result], items: Iterable[Item], name: Callable[[Item], str]) -> Iterator[Result]:
    for item in items:
        try:
            result = function(item)
        except Exception as error:  # whatever the item's function raises is raised with the item's name
            raise_named(error, name(item))
        yield result


def _start_deaf(process: BaseProcess) -> None:
    """Start a process with SIGINT blocked, so that a Ctrl-C while it still imports does not reach it."""
    resource_tracker.ensure_running()  # its own start would unblock the signal here
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(connection: Connection, function: Callable[[Any], Any]) -> None:
    """What a worker process does: an answer for each item, until nobody sends any more."""
    # Ctrl-C reaches every process of a terminal; the one that leads ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, daemon=True).start()
    while True:
        try:
            item = connection.recv()
        except (EOFError, ConnectionResetError):
            return
        try:
            answer = pickle.dumps(function(item))
        except Exception as error:  # whatever it is, it goes back to who sent the item
            answer = _failure(error)
        try:
            connection.send_bytes(answer)
        except BrokenPipeError:
            return


def _end_with_parent() -> None:
    """End this process when the one that leads has ended, by SIGTERM or kill -9: an item may take hours."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os.kill(os.getpid(), signal.SIGKILL)  # sys.exit would end this thread alone


def _failure(error: Exception) -> bytes:
    """An error as it goes through the pipe; one that does not survive it, as its text."""
    trace = traceback.format_exc()
    try:
        answer = pickle.dumps(_Failure(error, trace))
        pickle.loads(answer)
    except Exception:  # what pickling raises is up to the error's own class
        answer = pickle.dumps(_Failure(RuntimeError(f"{type(error).__name__}: {error}"), trace))
    return answer


def _ending(code: int | None) -> str:
    if code is not None and code < 0:
        return f"was ended by {signal.Signals(-code).name}"
    return f"ended with exit code {code}"
