"""Processes of nodes that start at once: forked from a process that has loaded what they need."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PATIENCE = 30.0  # [s] after a signal, when a node that still runs is taken to hang

# Forks one process for each line it reads, and states which; or waits for one's end, and states its exit code.
FORKS = """
import contextlib, gc, importlib, json, os, signal, sys
# Python's own handler would pass for the node's in a child that has just been forked.
signal.signal(signal.SIGINT, signal.SIG_DFL)
mains = {name: importlib.import_module(module).main for name, module in json.loads(sys.argv[1]).items()}
# Else every child spends its end on collecting what it shares with this process.
gc.collect()
gc.disable()
gc.freeze()
for line in sys.stdin:
    request = json.loads(line)
    if "end of" in request:
        answer = os.waitstatus_to_exitcode(os.waitpid(request["end of"], 0)[1])
    else:
        answer = os.fork()
        if not answer:
            # Where this user may: before other work of the machine, so that what is measured is the node's end. Of the
            # main thread's waits for a processor the test knows, not of those of a thread that it waits for.
            with contextlib.suppress(PermissionError):
                os.setpriority(os.PRIO_PROCESS, 0, -15)
            signal.signal(signal.SIGINT, signal.SIG_IGN if request["ignored"] else signal.SIG_DFL)
            output = os.open(request["output"], os.O_WRONLY | os.O_CREAT)
            os.dup2(output, 1)
            os.dup2(output, 2)
            os.environ["ROS_DOMAIN_ID"] = request["domain"]
            sys.argv = [request["name"], *request["words"]]
            mains[request["name"]]()
            sys.exit(0)
    print(json.dumps(answer), flush=True)
"""


@dataclass(frozen=True)
class Ending:
    """How a process ended.

    Attributes:
        code: its exit code.
        seconds: from the signal on, less those in which the process could have run, and the machine ran others.
        output: all it wrote.
    """

    code: int
    seconds: float
    output: str


class ForkedNode:
    """A running node."""

    def __init__(self, server: NodeServer, pid: int, output: Path) -> None:
        self._server, self._pid, self._output = server, pid, output
        self._sent = self._ended = self._held_up = 0.0
        self._watch = threading.Thread(target=self._note_end, daemon=True)

    def listens(self) -> bool:
        """True once it has a handler for SIGINT: from then on none may be lost."""
        status = Path(f"/proc/{self._pid}/status").read_text()
        caught = next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt"))
        return bool(int(caught, 16) >> (signal.SIGINT - 1) & 1)

    def signal(self, number: int) -> None:
        """Ask it once to end."""
        self._held_up, self._sent = self._processor_wait(), time.monotonic()
        os.kill(self._pid, number)
        self._watch.start()

    def _processor_wait(self) -> float:
        """How long its main thread was ready to run and had no processor, so far [s]."""
        return int(Path(f"/proc/{self._pid}/schedstat").read_text().split()[1]) / 1e9

    def _note_end(self) -> None:
        """Wait for its end, but no longer than PATIENCE: then it writes where it hangs, and is killed."""
        descriptor = os.pidfd_open(self._pid)
        poll = select.poll()
        poll.register(descriptor, select.POLLIN)
        try:
            if not poll.poll(PATIENCE * 1e3):
                os.kill(self._pid, signal.SIGUSR1)
                poll.poll(1e3)
                os.kill(self._pid, signal.SIGKILL)
                poll.poll()
        finally:
            os.close(descriptor)
        self._ended = time.monotonic()

    def end(self) -> Ending:
        """Wait for its end; one that hung was killed and has exit code -9."""
        self._watch.join()
        seconds = self._ended - self._sent - (self._processor_wait() - self._held_up)
        return Ending(self._server.ask({"end of": self._pid}), seconds, self._output.read_text())


class NodeServer:
    """Forks nodes."""

    def __init__(self, process: subprocess.Popen[str], folder: Path) -> None:
        self._process, self._folder, self._count = process, folder, 0

    def ask(self, request: dict[str, object]) -> int:
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def start(self, name: str, words: Sequence[str], domain: int, *, ignored: bool) -> ForkedNode:
        """A node in a ROS domain; ``ignored``: it inherits SIGINT as ignored, else as it is by default."""
        self._count += 1
        output = self._folder / f"{name}_{self._count}.txt"
        request = {"name": name, "words": words, "domain": str(domain), "ignored": ignored, "output": str(output)}
        return ForkedNode(self, self.ask(request), output)


@contextmanager
def node_server(modules: dict[str, str], folder: Path) -> Iterator[NodeServer]:
    """A server for these nodes (by name, the modules of their main functions); their output goes to the folder."""
    command = [sys.executable, "-c", FORKS, json.dumps(modules)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield NodeServer(process, folder)
        finally:
            process.stdin.close()
