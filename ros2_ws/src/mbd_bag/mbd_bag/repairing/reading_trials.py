"""Read changed bags as the tools do, each in a process of its own, and see how that ends."""

from __future__ import annotations

import multiprocessing
import resource
import signal
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from hashlib import sha256
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from mbd_model.errors import MbdError

from mbd_bag.repairing.mutations import MUTATIONS, mutate
from mbd_bag.session.command_line import open_session
from mbd_bag.storage.bag import Bag


class ReadingEnd(StrEnum):
    """How reading a changed bag ends; all from SILENT on are faults."""

    REFUSED = "refused"  # in one sentence
    SAID = "read, said"  # what is missing
    AS_BEFORE = "as before"
    SILENT = "silent"  # other messages are read, without a word
    TRACEBACK = "traceback"
    KILLED = "killed"  # the process ended by a signal


@dataclass(frozen=True)
class ReadingTrial:
    """One changed bag.

    Attributes:
        mutation: how it was changed.
        end: how reading it ended.
        words: what was said.
        seconds: how long reading took [s].
        megabytes: the most memory its process had [MB].
    """

    mutation: str
    end: ReadingEnd
    words: str
    seconds: float
    megabytes: float


Contents = Counter[tuple[str, int, bytes]]
# Where there is ROS, reading a session loads it at first use: half of what a trial of a small bag would take.
_LOADED_LATER = "mbd_bag.ros.session_conversions"


def contents_of(bag: Bag) -> Contents:
    """Every message of a bag."""
    return Counter((m.topic, m.log_time, sha256(m.data).digest()[:12]) for m in bag.messages())


def read_as_tools_do(path: Path, before: Contents) -> tuple[ReadingEnd, str]:
    """Read all of a bag and its session; how that ended, and what was said.

    Args:
        path: of the changed bag.
        before: what it held.
    """
    try:
        bag, session = open_session(path)
        problems = (*bag.check(), *session.problems)
        now = contents_of(bag)
    except MbdError as error:
        words = str(error)
        return (ReadingEnd.REFUSED if "\n" not in words else ReadingEnd.TRACEBACK), words
    if problems:
        return ReadingEnd.SAID, "; ".join(problems)
    return (ReadingEnd.AS_BEFORE if now == before else ReadingEnd.SILENT), ""


def reading_trial(path: Path, before: Contents, mutation: str, patience: int = 60) -> ReadingTrial:
    """Read one bag in a process of its own, which begins as a tool does: with what reading loads and nothing else.

    Args:
        path: of the changed bag.
        before: what it held.
        mutation: how it was changed.
        patience: after which the process is ended by SIGALRM [s].
    """
    begun = time.perf_counter()
    # Not forked from here: all that this process has loaded would count as memory that reading took.
    lean = multiprocessing.get_context("forkserver")
    lean.set_forkserver_preload([__name__, _LOADED_LATER])
    reading, writing = lean.Pipe(duplex=False)
    child = lean.Process(target=_read_and_tell, args=(path, before, writing, patience))
    child.start()
    writing.close()
    try:
        end, words, megabytes = reading.recv()
    except EOFError:
        end, words, megabytes = ReadingEnd.KILLED, "", 0.0
    child.join()
    if end is ReadingEnd.KILLED:
        words = f"exit status {child.exitcode}"
    return ReadingTrial(mutation, end, words, time.perf_counter() - begun, megabytes)


def _read_and_tell(path: Path, before: Contents, tell: Connection, patience: int) -> None:
    """In the other process: read, and tell how that ended, and how much memory it took [MB]."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(patience)
    try:
        end, words = read_as_tools_do(path, before)
    except BaseException:
        end, words = ReadingEnd.TRACEBACK, traceback.format_exc()
    tell.send((end, words, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


def reading_trials(bag: Path, number: int, seed: int, folder: Path) -> Iterator[ReadingTrial]:
    """So many changed copies of a bag, each kind of change in turn.

    Args:
        bag: intact.
        number: of trials.
        seed: decides on each change.
        folder: for the copies.
    """
    before = contents_of(Bag(bag))
    names = sorted(MUTATIONS)
    for k in range(number):
        name = names[k % len(names)]
        mutate(bag, folder / "changed", name, np.random.default_rng([seed, k]))
        yield reading_trial(folder / "changed", before, name)
