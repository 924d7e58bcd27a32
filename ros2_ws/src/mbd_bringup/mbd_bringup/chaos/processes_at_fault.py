"""Do to running nodes what a fault is, and undo it when its time is over."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
from collections.abc import Callable, Sequence

from mbd_bringup.chaos.faults import FaultKind, PlannedFault
from mbd_bringup.processes import NodeProcess

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
            before.append((node.process.pid, found))

    def undo() -> None:
        for process, found in before:
            with contextlib.suppress(ProcessLookupError):
                resource.prlimit(process, resource.RLIMIT_FSIZE, found)

    return undo


def set_network(*, up: bool) -> None:
    """Have the loopback device of this network namespace up or down; only in one of our own, see `own_network`."""
    subprocess.run(["ip", "link", "set", "lo", "up" if up else "down"], check=True)


def own_network(words: Sequence[str]) -> None:
    """Become the command ``words`` in a network namespace of its own; returns where that cannot be."""
    made = ["unshare", "-n", "sh", "-c", 'ip link set lo up multicast on && exec "$@"', "sh"]
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):
        if subprocess.run([*made, "true"], capture_output=True, timeout=20.0, check=False).returncode == 0:
            os.execvp(made[0], [*made, *words])
