"""The two options of every command that computes many sessions or problems: ``--jobs`` and ``--scheduler``."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace

from mbd_model.command_line.values import at_least_one
from mbd_model.parallel.cluster import DaskCluster
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.local_processes import LocalProcesses


def all_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0))


def add_executor_options(parser: ArgumentParser, what: str) -> None:
    """Add ``--jobs`` and ``--scheduler``, of which only one can be given.

    Args:
        parser: of a command.
        what: is computed at the same time, in the plural.
    """
    group = parser.add_mutually_exclusive_group()
    # No default: argparse does not notice a second option of the group that gives the default.
    group.add_argument(
        "--jobs", type=at_least_one, help=f"{what} at a time, a process each (default: as many as cores)"
    )
    group.add_argument(
        "--scheduler", metavar="ADDRESS", help=f"compute the {what} on an existing Dask cluster (tcp://host:8786)"
    )


def executor_of(arguments: Namespace, most_jobs: int | None = None) -> Executor:
    """The executor that a command was asked to use.

    Args:
        arguments: as parsed.
        most_jobs: local processes worth starting; None: as many as were asked for.
    """
    if arguments.scheduler is not None:
        return DaskCluster(arguments.scheduler)
    jobs = all_cores() if arguments.jobs is None else arguments.jobs
    return LocalProcesses(jobs if most_jobs is None else min(jobs, most_jobs))
