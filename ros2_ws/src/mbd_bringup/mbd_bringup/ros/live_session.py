"""A session that is running: its processes, and the node that follows it."""

from __future__ import annotations

import contextlib
import queue
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import rclpy
from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from mbd_model.errors import MbdError
from mbd_model.session import Phase

from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.background import spin_in_background
from mbd_bringup.ros.follow import SessionEvent, SessionFollower

OVER = (Phase.DONE, Phase.ABORTED)


def install_prefixes(packages: Sequence[str]) -> dict[str, Path]:
    """Install prefix of each package; raises MbdError for one that is not built."""
    try:
        return {name: Path(get_package_prefix(name)) for name in packages}
    except PackageNotFoundError as error:
        raise MbdError(f"package {error} is not in this environment; run: make build, then: source env.sh") from error


class LiveSession:
    """Starts every node of a session. Use it as a context manager.

    Args:
        options: what to start.
        domain: ROS domain to do so in; None: one of its own.

    Attributes:
        options: the same.
        domain: the ROS domain it is in, once started.
        follower: node that receives what the session publishes.
        processes: the nodes' processes.
        phase: where the session is, None before its first state.
    """

    def __init__(self, options: SessionOptions, domain: int | None = None) -> None:
        self.options = options
        self._given_domain = domain
        self.phase: Phase | None = None
        self._exit = contextlib.ExitStack()

    def __enter__(self) -> LiveSession:
        specs = session_nodes(self.options)
        packages = {s.package for s in specs} | {package for s in specs for package, _ in s.config if package}
        prefixes = install_prefixes(sorted(packages))
        with self._exit:
            given = self._given_domain
            self.domain = self._exit.enter_context(private_domain()) if given is None else given
            context = rclpy.Context()
            rclpy.init(context=context, domain_id=self.domain)
            self.follower = SessionFollower(context=context)
            self._exit.callback(spin_in_background(self.follower))
            environment = {"ROS_DOMAIN_ID": str(self.domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
            self.processes = self._exit.enter_context(SessionProcesses(prefixes, self.logs, environment))
            for spec in specs:
                self.processes.start(spec)
            self._exit = self._exit.pop_all()
        return self

    def __exit__(self, *error: object) -> None:
        self._exit.close()

    @property
    def logs(self) -> Path:
        """Folder of the nodes' output."""
        return self.options.folder / "logs"

    def events(self, timeout: float) -> Iterator[SessionEvent | None]:
        """What happens, one by one, until the session is over; None at least every 0.25 s, to keep a display alive.

        Args:
            timeout: seconds for the complete session.

        Raises:
            MbdError: a node ended by itself (with its last words), or the time is over.
        """
        begun = time.monotonic()
        while self.phase not in OVER:
            event: SessionEvent | None = None
            with contextlib.suppress(queue.Empty):
                event = self.follower.events.get(timeout=0.25)
            if event is not None:
                self.phase = event.phase or self.phase
            yield event
            for node in self.processes.dead():
                raise MbdError(
                    f"node '{node.name}' ended with code {node.process.returncode}; "
                    f"the end of {node.log}:\n{node.log_tail()}"
                )
            if time.monotonic() - begun > timeout:
                raise MbdError(f"the session took more than {timeout:g} s; it was in phase {self.phase!s}")
