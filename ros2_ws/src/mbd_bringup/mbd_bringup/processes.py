"""The processes of a session: started with their logs, watched, and ended in order."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import TracebackType

from mbd_model.errors import MbdError
from mbd_model.folders import make_folder

from mbd_bringup.nodes import NodeSpec
from mbd_bringup.robot_settings import Parameter
from mbd_bringup.transport import profile_variables

# Whoever ends so soon after its start, so often in turn, does not come up; all else comes back as under ros2 launch.
_SOON, _MOST_DEATHS = 10.0, 3
_ASK_AGAIN = 1.0  # [s] until a node that was asked to end, and has not, is asked again


@cache
def _with_default_signals() -> tuple[str, ...]:
    """Words before a command that give it SIGINT and SIGTERM as they are by default.

    A script's ``&`` starts what it runs with SIGINT ignored, and every process below inherits that. (Not by Popen's
    preexec_fn, which may hang in a process with threads.) Empty where env does not know the option: coreutils before
    8.31, or another system.
    """
    words = ("env", "--default-signal=INT,TERM")
    try:
        known = subprocess.run([*words, "true"], stderr=subprocess.DEVNULL, timeout=10.0, check=False).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        known = False
    return words if known else ()


def _ending_with_parent() -> tuple[str, ...]:
    """Words before a command that have the kernel interrupt it when its parent dies, even by kill -9.

    So no session is left running. Empty where util-linux's setpriv is not installed.
    """
    setpriv = shutil.which("setpriv")
    return (setpriv, "--pdeathsig", "INT") if setpriv else ()


def _yaml_word(value: Parameter) -> str:
    """A parameter's value as ROS reads it from the command line: a text in quotes, whatever it looks like."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    return repr(value) if isinstance(value, int | float) else f"[{', '.join(_yaml_word(v) for v in value)}]"


@dataclass
class NodeProcess:
    """A running node.

    Attributes:
        spec: what it runs.
        command: the complete command line, so that it can be started again.
        process: its process, leader of its own group.
        log: file that takes its output.
        started: when it was, by a steady clock [s].
    """

    spec: NodeSpec
    command: tuple[str, ...]
    process: subprocess.Popen[bytes]
    log: Path
    started: float = field(default_factory=time.monotonic)

    @property
    def name(self) -> str:
        """The executable's name, which is also the node's."""
        return self.spec.executable

    def log_tail(self, lines: int = 12) -> str:
        """The last lines of its output."""
        return "\n".join(self.log.read_text(errors="replace").splitlines()[-lines:])


class Deaths:
    """Counts how often in turn each node ended right after its start."""

    def __init__(self) -> None:
        self._in_turn: dict[str, int] = {}

    def gives_up(self, name: str, code: int, age: float) -> bool:
        """Whether a node that has ended does not come up: it refuses its parameters, or lacks something.

        Args:
            name: of the node.
            code: it ended with; below 0: a signal ended it, and it comes back.
            age: from its start to its end [s].
        """
        self._in_turn[name] = self._in_turn.get(name, 0) + 1 if code > 0 and age < _SOON else 0
        return self._in_turn[name] >= _MOST_DEATHS


def _wait_for_all(nodes: Sequence[NodeProcess], seconds: float) -> None:
    """Until the last of the nodes has ended, but no longer than ``seconds``."""
    deadline = time.monotonic() + seconds
    for node in nodes:
        with contextlib.suppress(subprocess.TimeoutExpired):
            node.process.wait(max(0.0, deadline - time.monotonic()))


class SessionProcesses:
    """Starts nodes and makes sure that they end. Use it as a context manager.

    Args:
        prefixes: install prefix of each package.
        logs: folder for one log file a node.
        environment: variables for every node (ROS_DOMAIN_ID and the like), besides this process's own.
    """

    def __init__(self, prefixes: Mapping[str, Path], logs: Path, environment: Mapping[str, str]) -> None:
        self._prefixes = prefixes
        self._logs = logs
        self._environment = {**os.environ, "PYTHONUNBUFFERED": "1", **environment}
        self._nodes: list[NodeProcess] = []

    def __enter__(self) -> SessionProcesses:
        make_folder(self._logs)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()

    def command(self, spec: NodeSpec) -> tuple[str, ...]:
        """The command line of a node; raises MbdError when its executable is not installed."""
        executable = self._prefixes[spec.package] / "lib" / spec.package / spec.executable
        if not executable.exists():
            raise MbdError(f"{spec.package} has no executable '{spec.executable}' at {executable}; run: make build")
        words = [*_ending_with_parent(), *_with_default_signals(), str(executable), "--ros-args"]
        for package, file in spec.config:
            own = Path(file) if not package else self._prefixes[package] / "share" / package / "config" / file
            words += ["--params-file", str(own)]
        for name, value in spec.parameters.items():
            words += ["-p", f"{name}:={_yaml_word(value)}"]
        return tuple(words)

    def start(self, spec: NodeSpec) -> NodeProcess:
        """Start a node; its output goes (is appended) to ``<executable>.log``."""
        command = self.command(spec)
        log = self._logs / f"{spec.executable}.log"
        with log.open("ab") as stream:
            # A session of its own: Ctrl-C in the terminal reaches only the parent, which ends the nodes in order.
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                env={**self._environment, **profile_variables(self._environment, shared_memory=spec.shared_memory)},
                start_new_session=True,
            )
        node = NodeProcess(spec, command, process, log)
        # One that is started again keeps its place: the recorder, which was first, ends last.
        places = {other.name: place for place, other in enumerate(self._nodes)}
        place = places.get(node.name, len(self._nodes))
        self._nodes[place : place + 1] = [node]
        return node

    def restart(self, name: str) -> NodeProcess:
        """Kill a node as ``kill -9`` would and start it again."""
        node = self[name]
        os.killpg(node.process.pid, signal.SIGKILL)
        node.process.wait()
        return self.start(node.spec)

    @staticmethod
    def _kill_hanging(node: NodeProcess) -> None:
        """Kill a node that does not end, after it had a second to write into its log where it hangs."""
        os.killpg(node.process.pid, signal.SIGUSR1)
        try:
            node.process.wait(1.0)
        except subprocess.TimeoutExpired:
            os.killpg(node.process.pid, signal.SIGKILL)
            node.process.wait()

    def __getitem__(self, name: str) -> NodeProcess:
        """The node of that executable's name; raises MbdError listing the names there are."""
        for node in self._nodes:
            if node.name == name:
                return node
        raise MbdError(f"no node '{name}' was started; there are {[n.name for n in self._nodes]}")

    @property
    def nodes(self) -> Sequence[NodeProcess]:
        """Every node, each by its last start."""
        return tuple(self._nodes)

    def dead(self) -> Sequence[NodeProcess]:
        """Nodes that have ended although nobody stopped them."""
        return [n for n in self._nodes if n.process.poll() is not None]

    def stop(self, *, patience: float = 10.0) -> Sequence[str]:
        """End every node: the recorder, which was started first, after the others, so that it sees them out.

        A node is asked by SIGINT, again every second (one that is just starting may not take notice of the first), and
        killed by SIGKILL when its patience ends.

        Args:
            patience: seconds the nodes have before they are killed.

        Returns:
            Names of the nodes that had to be killed.
        """
        killed = []
        # All but the first-started at once: they do not depend on each other, and the recorder ends last.
        for group in (self._nodes[1:], self._nodes[:1]):
            deadline = time.monotonic() + patience
            running = [node for node in group if node.process.poll() is None]
            while running and (left := deadline - time.monotonic()) > 0.0:
                for node in running:
                    os.killpg(node.process.pid, signal.SIGINT)
                _wait_for_all(running, min(left, _ASK_AGAIN))
                running = [node for node in running if node.process.poll() is None]
            for node in running:
                self._kill_hanging(node)
                killed.append(node.name)
        self._nodes = []
        return killed
