"""Recorders that start at once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # what tests of this folder share

# Has loaded what a recorder needs, and forks one for each line: a process of its own, without the seconds of loading.
FORKS = """
import json, os, sys
from mbd_bag.ros import recorder_node
for line in sys.stdin:
    request = json.loads(line)
    if "poll" in request:
        pid, status = os.waitpid(request["poll"], os.WNOHANG)
        answer = os.waitstatus_to_exitcode(status) if pid else None
    else:
        answer = os.fork()
        if not answer:
            output = os.open(request["output"], os.O_WRONLY | os.O_CREAT)
            os.dup2(output, 1)
            os.dup2(output, 2)
            os.environ["ROS_DOMAIN_ID"] = request["domain"]
            sys.argv = ["recorder", *request["words"]]
            recorder_node.main()
    print(json.dumps(answer), flush=True)
"""


class ForkedRecorder:
    """A running recorder, with what a Popen has."""

    def __init__(self, server: RecorderServer, pid: int, output: Path) -> None:
        self._server, self.pid, self._output = server, pid, output
        self.returncode: int | None = None

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)

    def poll(self) -> int | None:
        if self.returncode is None:
            self.returncode = self._server.ask({"poll": self.pid})
        return self.returncode

    def wait(self, timeout: float = 60.0) -> int:
        deadline = time.monotonic() + timeout
        while (code := self.poll()) is None:
            assert time.monotonic() < deadline, f"the recorder did not end in {timeout} s"
            time.sleep(0.01)
        return code

    def output(self) -> str:
        """All it wrote, once it has ended."""
        self.wait()
        return self._output.read_text()


class RecorderServer:
    """Forks recorders."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._count = folder, 0
        command = [sys.executable, "-c", FORKS]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)

    def ask(self, request: dict[str, object]) -> int | None:
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def start(self, domain: int, *words: str) -> ForkedRecorder:
        """A recorder in a ROS domain.

        Args:
            domain: its id.
            words: of the command line.
        """
        self._count += 1
        output = self._folder / f"recorder_{self._count}.txt"
        pid = self.ask({"domain": str(domain), "words": words, "output": str(output)})
        return ForkedRecorder(self, pid, output)


@pytest.fixture(scope="session")
def recorders(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RecorderServer]:
    server = RecorderServer(tmp_path_factory.mktemp("recorders"))
    yield server
    server.process.stdin.close()
    server.process.wait()
    server.process.stdout.close()
