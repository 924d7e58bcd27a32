"""Files of others read within bounds: in a process of its own, whatever the library that reads them does with them.

A bag of 65 KB may decompress to gigabytes, nest so deeply that its parser crashes, or have no end. What reads it here
is others' code (rosbags, h5py, pyarrow, numpy), so that the bounds are those of a process.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

from mbd_model.errors import MbdError

from mbd_demonstration.recording_files import RecordingFileError

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

# Beside what the process has when it begins, about 100 MB: at most this [MB], and so many bytes for each of the file.
# Bags hold pictures, which are passed over one by one; of a table every number becomes an object of Python.
MEMORY, PER_BYTE_OF_BAG, PER_BYTE_OF_TABLE = 256, 3, 20
# Of the processor: at most this [s], and one second more for so many bytes. By the clock a multiple of it.
SECONDS, BYTES_PER_SECOND, BY_THE_CLOCK = 10, 4_000_000, 12
_LONGEST_WORDS = 500  # characters of an error: some quote the file


@dataclass(frozen=True)
class _Bounds:
    """Memory [MB] and processor time [s] that reading may take."""

    megabytes: int
    seconds: int


def read_bounded(
    read: Callable[Concatenate[Path, Arguments], Result], path: Path, *rest: Arguments.args, **named: Arguments.kwargs
) -> Result:
    """What ``read(path, *rest)`` returns, within bounds of memory and time that grow with the file.

    Args:
        read: a function of a module, which reads the file; what it returns must be picklable.
        path: of a file or folder. A pipe is read here, without bounds: no other process can open it again.
        rest: what else the function takes.
        named: what it takes by name.

    Raises:
        RecordingFileError: the function raised something, took more than the bounds, or crashed.
    """
    if not (path.is_file() or path.is_dir()):
        return read(path, *rest, **named)
    bounds = _bounds(path)
    server = multiprocessing.get_context("forkserver")
    server.set_forkserver_preload([read.__module__, "rosbags.highlevel"])
    receiving, sending = server.Pipe(duplex=False)
    work = partial(read, path, *rest, **named)
    child = server.Process(target=_read_and_send, args=(work, path, sending, bounds, Path.cwd()), daemon=True)
    child.start()
    sending.close()
    try:
        came = receiving.poll(BY_THE_CLOCK * bounds.seconds)
        value, words = receiving.recv() if came else (None, "")
    except EOFError:
        value, words = None, ""
    if value is None:
        child.kill()
    child.join()
    if value is None:
        raise RecordingFileError(words or f"cannot read {path}: {_end(child.exitcode, bounds.seconds)}")
    return cast(Result, value[0])


def _bounds(path: Path) -> _Bounds:
    """What reading a file, or all files of a folder, may take."""
    files = [path] if path.is_file() else [p for p in path.iterdir() if p.is_file()]
    size = sum(p.stat().st_size for p in files)
    each = PER_BYTE_OF_BAG if path.is_dir() or path.suffix in (".mcap", ".db3") else PER_BYTE_OF_TABLE
    return _Bounds(MEMORY + each * size // 1_000_000, SECONDS + size // BYTES_PER_SECOND)


def _end(status: int | None, seconds: int) -> str:
    if status in (-signal.SIGXCPU, -signal.SIGKILL):
        return f"it took more than {seconds} s of processor time; no recording of its size does"
    return f"its reader crashed (exit status {status}): it is damaged"


def _read_and_send(work: Callable[[], object], path: Path, sending: Connection, bounds: _Bounds, folder: Path) -> None:
    """In the other process: read, and send ((what was read,), "") or (None, what is wrong in one sentence)."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it without a word
    os.chdir(folder)
    resource.setrlimit(resource.RLIMIT_CPU, (bounds.seconds, bounds.seconds + 1))
    limit = _held() + bounds.megabytes * 1_000_000
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    answer: tuple[Any, str]
    try:
        answer = (work(),), ""
    except MemoryError:
        answer = (
            None,
            f"cannot read {path}: it took more than {bounds.megabytes} MB; no recording of its size does",
        )
    except MbdError as error:
        answer = None, _brief(str(error))
    except Exception as error:  # of others' readers: each raises its own
        answer = None, _brief(f"cannot read {path}: {error or type(error).__name__}")
    sending.send(answer)


def _brief(words: str) -> str:
    line = " ".join(words.split())
    return line if len(line) <= _LONGEST_WORDS else f"{line[:_LONGEST_WORDS]}..."


def _held() -> int:
    """What this process holds of what the limit counts [byte]."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmData:"):
            return int(line.split()[1]) * 1024
    return 0
