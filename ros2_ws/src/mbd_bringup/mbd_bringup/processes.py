"""The processes of a session: started with their logs, watched, and ended in order."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from mbd_model.errors import MbdError

from mbd_bringup.nodes import NodeSpec, Parameter
from mbd_bringup.transport import profile_variables


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
    return "'" + value.replace("'", "''") + "'" if isinstance(value, str) else repr(value)


@dataclass
class NodeProcess:
    """A running node.

    Attributes:
        spec: what it runs.
        command: the whole command line, so that it can be started again.
        process: its process, leader of its own group.
        log: file that takes its output.
    """

    spec: NodeSpec
    command: tuple[str, ...]
    process: subprocess.Popen[bytes]
    log: Path

    @property
    def name(self) -> str:
        """The executable's name, which is also the node's."""
        return self.spec.executable

    def log_tail(self, lines: int = 12) -> str:
        """The last lines of its output."""
        return "\n".join(self.log.read_text(errors="replace").splitlines()[-lines:])


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
        self._logs.mkdir(parents=True, exist_ok=True)
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
        words = [*_ending_with_parent(), str(executable), "--ros-args"]
        if spec.config is not None:
            package, file = spec.config
            words += ["--params-file", str(self._prefixes[package] / "share" / package / "config" / file)]
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
                env={**self._environment, **profile_variables(self._environment, images=spec.images)},
                start_new_session=True,
            )
        node = NodeProcess(spec, command, process, log)
        self._nodes = [n for n in self._nodes if n.name != node.name] + [node]
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

    def dead(self) -> Sequence[NodeProcess]:
        """Nodes that have ended although nobody stopped them."""
        return [n for n in self._nodes if n.process.poll() is not None]

    def stop(self, *, patience: float = 10.0) -> Sequence[str]:
        """End every node: SIGINT in reverse order of starting, so that the recorder sees the others out, then SIGKILL.

        Args:
            patience: seconds a node has before it is killed.

        Returns:
            Names of the nodes that had to be killed.
        """
        killed = []
        # All but the first-started at once: they do not depend on each other, and the recorder ends last.
        for group in (self._nodes[1:], self._nodes[:1]):
            for node in group:
                if node.process.poll() is None:
                    os.killpg(node.process.pid, signal.SIGINT)
            for node in group:
                try:
                    node.process.wait(patience)
                except subprocess.TimeoutExpired:
                    self._kill_hanging(node)
                    killed.append(node.name)
        self._nodes = []
        return killed
