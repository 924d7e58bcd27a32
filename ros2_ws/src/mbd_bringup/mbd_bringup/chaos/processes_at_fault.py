"""Do to running nodes what a fault is, and undo it when its time is over."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from mbd_model.errors import MbdError

from mbd_bringup.chaos.faults import FaultKind, PlannedFault
from mbd_bringup.processes import NodeProcess

_NETWORK = Path("/proc/self/ns/net")  # a link whose text names the namespace
_FORMER_NETWORK = "MBD_CHAOS_FORMER_NETWORK"  # set in a process that was given a network of its own: the one before
_SIGNALS = {
    FaultKind.KILL: signal.SIGKILL,
    FaultKind.STOP: signal.SIGSTOP,
    FaultKind.CAMERA: signal.SIGSTOP,
    FaultKind.INTERRUPT: signal.SIGINT,
    FaultKind.TERMINATE: signal.SIGTERM,
}


def strike(fault: PlannedFault, nodes: Sequence[NodeProcess], jump: Callable[[], object]) -> Callable[[], None] | None:
    """Let a fault begin.

    Args:
        fault: which.
        nodes: of the session, as they run now.
        jump: has the session's clock jump.

    Returns:
        What ends it; None when it could not begin, for its victim does not run.
    """
    victims = [n for n in nodes if n.process.poll() is None and fault.victim in ("", n.name)]
    if not victims:
        return None
    if fault.kind is FaultKind.CLOCK:
        jump()
        return lambda: None
    if fault.kind is FaultKind.NETWORK:
        set_network(up=False)
        return lambda: set_network(up=True)
    if fault.kind is FaultKind.DISK:
        return limit_files(victims)
    for node in victims:
        os.killpg(node.process.pid, _SIGNALS[fault.kind])
    return lambda: _go_on(victims)


def _go_on(nodes: Sequence[NodeProcess]) -> None:
    for node in nodes:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(node.process.pid, signal.SIGCONT)


def limit_files(nodes: Sequence[NodeProcess]) -> Callable[[], None]:
    """Let no file of these nodes grow: a write fails as on a full disk (EFBIG in place of ENOSPC); returns the end."""
    before: list[tuple[int, tuple[int, int]]] = []
    for node in nodes:
        with contextlib.suppress(ProcessLookupError):
            found = resource.prlimit(node.process.pid, resource.RLIMIT_FSIZE)
            resource.prlimit(node.process.pid, resource.RLIMIT_FSIZE, (0, found[1]))
            # Of two such faults at a time the second finds the first one's limit, which is not to be what remains.
            before.append((node.process.pid, found if found[0] else (found[1], found[1])))

    def undo() -> None:
        for process, found in before:
            with contextlib.suppress(ProcessLookupError):
                resource.prlimit(process, resource.RLIMIT_FSIZE, found)

    return undo


def set_network(*, up: bool) -> None:
    """Have the loopback device of our own network namespace up or down; raises MbdError in the machine's."""
    if not in_own_network():
        raise MbdError("the machine's own network is not cut: that fault is for a network namespace of our own")
    subprocess.run(["ip", "link", "set", "lo", "up" if up else "down"], check=True)


def in_own_network() -> bool:
    """Whether this process is in a network namespace that `own_network` made."""
    before = os.environ.get(_FORMER_NETWORK, "")
    return bool(before) and before != str(_NETWORK.readlink())


def own_network(words: Sequence[str]) -> None:
    """Become the command ``words`` in a network namespace of its own; returns where that cannot be."""
    os.environ[_FORMER_NETWORK] = str(_NETWORK.readlink())
    made = ["unshare", "-n", "sh", "-c", 'ip link set lo up multicast on && exec "$@"', "sh"]
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):
        if subprocess.run([*made, "true"], capture_output=True, timeout=20.0, check=False).returncode == 0:
            os.execvp(made[0], [*made, *words])
