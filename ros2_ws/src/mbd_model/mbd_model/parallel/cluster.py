"""An existing Dask cluster: a study that outgrows one machine is computed by the workers of many."""

from __future__ import annotations

import socket
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from importlib import import_module
from typing import Any

from mbd_model.errors import MbdError
from mbd_model.parallel.executor import AHEAD, Item, ItemError, Result, raise_named

INSTALL = "pip install -r requirements/cluster.txt"
CONNECTING = 10.0  # [s] until a scheduler must have answered
LOOK_EVERY = 5.0  # [s] between looks whether there is a worker at all
DESERTED = 60.0  # [s] without any worker until giving up: one that was killed may be started again


class DaskCluster:
    """The workers of a running Dask scheduler.

    They import the same version of the project, and see the same files under the same paths. What a killed worker had
    is done again by another; the scheduler gives an item up when its workers die one after the other
    (``distributed.scheduler.allowed-failures``, 3 unless configured).

    Args:
        address: of the scheduler, as ``tcp://host:8786``.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def __str__(self) -> str:
        return f"Dask cluster {self.address}"

    def run_all(
        self, function: Callable[[Item], Result], items: Iterable[Item], name: Callable[[Item], str] = str
    ) -> Iterator[Result]:
        """See `Executor.run_all`.

        Raises:
            MbdError: besides, Dask is not installed, no scheduler answers there, or it has no workers (any more).
        """
        client = self._connect()
        pending: deque[tuple[Item, Any]] = deque()
        try:
            threads = sum(client.nthreads().values())
            if not threads:
                raise MbdError(
                    f"the Dask scheduler at {self.address} has no workers; start some: "
                    f"dask worker {self.address} --nthreads 1 --nworkers auto"
                )
            for item in items:
                # Not pure: two equal items are two items, and nothing is kept for another run.
                pending.append((item, client.submit(function, item, pure=False)))
                if len(pending) >= AHEAD * threads:
                    yield self._result(client, *pending.popleft(), name)
            while pending:
                yield self._result(client, *pending.popleft(), name)
        finally:
            if pending:
                client.cancel([future for _, future in pending], force=True)
            client.close()

    def _connect(self) -> Any:
        distributed = _dask()
        try:
            # Asked for first: Dask's own client states much more about an address where nobody listens.
            host, port = self.address.rpartition("://")[2].rsplit(":", 1)
            socket.create_connection((host.strip("[]"), int(port)), timeout=CONNECTING).close()
            return distributed.Client(self.address, timeout=CONNECTING, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise MbdError(
                f"no Dask scheduler answers at '{self.address}' ({error}); "
                "start one (dask scheduler) and give the address it prints, as tcp://host:8786"
            ) from error

    def _result(self, client: Any, item: Item, future: Any, name: Callable[[Item], str]) -> Any:
        try:
            error = self._ended(client, future)
            result = future.result() if error is None else None
        except (OSError, CancelledError) as gone:
            raise MbdError(f"the Dask scheduler at {self.address} has gone ({gone})") from gone
        if isinstance(error, _dask().KilledWorker):
            raise ItemError(f"{name(item)}: the workers that tried it were killed one after the other") from error
        if error is not None:
            raise_named(error, name(item))
        return result

    def _ended(self, client: Any, future: Any) -> Exception | None:
        """What computing an item raised; waits for its end, and raises MbdError when nobody is left to do it."""
        deserted = 0.0
        while True:
            try:
                error: Exception | None = future.exception(timeout=LOOK_EVERY)
            except TimeoutError:
                deserted = 0.0 if client.nthreads() else deserted + LOOK_EVERY
            else:
                return error
            if deserted >= DESERTED:
                raise MbdError(
                    f"the Dask scheduler at {self.address} has had no worker for {deserted:.0f} s; start some again"
                )


def _dask() -> Any:
    """Dask's module; raises MbdError when it is not installed."""
    try:
        return import_module("distributed")
    except ImportError as error:
        raise MbdError(f"--scheduler needs Dask, which is not installed: {INSTALL}") from error
