"""Which tier a test belongs to, what xdist may run side by side, and in which order.

``unit``: no ROS node, nothing slow. ``node``: one or two nodes, in this process or as processes. ``system``: many
processes (of a session, a cluster, a build), a complete session in the simulated cell, or a complete real study. A mark
on a test or its module decides; else all below ``tests/system`` are of tier system, all that take a private ROS domain
of tier node, and the others of tier unit.

A test marked ``alone`` measures time by the wall clock: nothing else runs meanwhile.
"""

from __future__ import annotations

import fcntl
import os
import re
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from itertools import zip_longest
from pathlib import Path

import pytest
import rclpy
from xdist.scheduler import LoadScopeScheduling
from xdist.workermanage import WorkerController

TIERS = {
    "unit": "no ROS node and nothing slow: part of `make check`",
    "node": "one or two nodes, in this process or as processes of their own",
    "system": "many processes, a complete session in the simulated cell, or a complete real study",
}
# Sessions that share nothing with the other tests of their module. The longest, they begin first.
EACH_FOR_ITSELF = re.compile(
    r"tests/system/(test_console_sessions\.py|test_robots\.py::test_a_session|test_session\.py::test_the_demo)"
)
HERE = Path(__file__).parent


def pytest_configure(config: pytest.Config) -> None:
    """Make the tiers known, and have xdist take the groups in the order given here."""
    for name, meaning in TIERS.items():
        config.addinivalue_line("markers", f"{name}: {meaning}")
    config.addinivalue_line("markers", "alone: measures time by the wall clock, so nothing else runs meanwhile")
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


class Groups(LoadScopeScheduling):
    """Hands xdist's workers one group of tests after the other, in the order of ``longest_first``.

    xdist 3.8 does not see its own group marks with pytest 9.2, so the group is read off a test's name.
    """

    def _split_scope(self, nodeid: str) -> str:
        return group_of(nodeid)

    def _assign_work_unit(self, node: WorkerController) -> None:
        """As many workers as there are cores take sessions, of a dozen processes each; the rest what else there is."""
        takes_sessions = int(node.gateway.id.removeprefix("gw")) < (os.cpu_count() or 1)
        fitting = (g for g in self.workqueue if g.startswith("tests/system/") == takes_sessions)
        self.workqueue.move_to_end(next(fitting, next(iter(self.workqueue))), last=False)
        super()._assign_work_unit(node)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> Groups:
    """Let the groups be ours, whatever ``--dist`` names."""
    return Groups(config, log)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test by its tier, and put those first that take longest."""
    for item in items:
        tier = tier_of(item)
        if item.get_closest_marker(tier) is None:
            item.add_marker(tier)
    items[:] = longest_first(items)


def tier_of(item: pytest.Item) -> str:
    """The tier of a test; raises UsageError when it has marks of two."""
    marked = [mark.name for mark in item.iter_markers() if mark.name in TIERS]
    if len(set(marked)) > 1 and not any(mark.name in TIERS for mark in item.own_markers):
        raise pytest.UsageError(f"{item.nodeid} is marked {' and '.join(marked)}, but a test belongs to one tier")
    if marked:
        return marked[0]
    if item.path.is_relative_to(HERE / "system"):
        return "system"
    return "node" if "ros_domain" in getattr(item, "fixturenames", ()) else "unit"


def group_of(nodeid: str) -> str:
    """What runs on one worker: a module, for its fixtures' sake; but each of ``EACH_FOR_ITSELF``."""
    return nodeid if EACH_FOR_ITSELF.search(nodeid) else nodeid.partition("::")[0]


def longest_first(items: Sequence[pytest.Item]) -> list[pytest.Item]:
    """Sessions and nodes in turn, as the ones compute and the others mostly wait; unit tests fill up what is left.

    Groups in which tests are to run alone come at the end, where they and the others wait least for one another.
    """
    groups: dict[str, list[pytest.Item]] = {}
    for item in items:
        groups.setdefault(group_of(item.nodeid), []).append(item)
    by_tier: dict[str, list[list[pytest.Item]]] = {name: [] for name in (*TIERS, "alone")}
    for group in groups.values():
        # A module of two tiers goes by the higher.
        tier = max((tier_of(item) for item in group), key=list(TIERS).index)
        by_tier["alone" if any(map(is_alone, group)) else tier].append(sorted(group, key=is_alone))
    sessions = sorted(by_tier["system"], key=lambda group: EACH_FOR_ITSELF.search(group[0].nodeid) is None)
    in_turn = [g for pair in zip_longest(sessions, by_tier["node"]) for g in pair if g is not None]
    return [item for group in (*in_turn, *by_tier["unit"], *by_tier["alone"]) for item in group]


def is_alone(item: pytest.Item) -> bool:
    """Whether the test is to run alone."""
    return item.get_closest_marker("alone") is not None


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Run a test with its fixtures: under xdist alone, if it is to; without ROS, if it is of tier unit."""
    with in_turn(item), without_ros(item):
        return (yield)


@contextmanager
def in_turn(item: pytest.Item) -> Iterator[None]:
    """Have the workers' tests wait for one that is to run alone, and that one for them."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        yield
        return
    alone = is_alone(item)
    # Any two files that all workers have.
    with (HERE / "conftest.py").open() as gate, (HERE / "tiers.py").open() as room:
        # Whoever is to be alone keeps the gate closed until he leaves; the others only pass it.
        fcntl.flock(gate, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        fcntl.flock(room, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        if not alone:
            fcntl.flock(gate, fcntl.LOCK_UN)
        yield


@contextmanager
def without_ros(item: pytest.Item) -> Iterator[None]:
    """Have a unit test, or a fixture of it, that opens ROS fail: it belongs to another tier."""
    if tier_of(item) != "unit":
        yield
        return

    def refuse(*_words: object, **_options: object) -> None:
        pytest.fail("a test of tier unit opened a ROS context: mark it pytest.mark.node (see tests/tiers.py)")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rclpy.Context, "init", refuse)
        yield
