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
from collections.abc import Generator, Iterator, Sequence
from itertools import chain, zip_longest
from pathlib import Path

import pytest
import rclpy

TIERS = {
    "unit": "no ROS node and nothing slow: part of `make check`",
    "node": "one or two nodes, in this process or as processes of their own",
    "system": "many processes, a complete session in the simulated cell, or a complete real study",
}
GROUP = "xdist_group"
HERE = Path(__file__).parent


def pytest_configure(config: pytest.Config) -> None:
    """Make the tiers known, and have xdist take the groups in the order given here."""
    for name, meaning in TIERS.items():
        config.addinivalue_line("markers", f"{name}: {meaning}")
    config.addinivalue_line("markers", "alone: measures time by the wall clock, so nothing else runs meanwhile")
    # `colcon test` runs without xdist, which else makes this mark known.
    config.addinivalue_line("markers", f"{GROUP}(name): tests that run on one worker")
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test by its tier and group, and put those first that take longest."""
    for item in items:
        tier = tier_of(item)
        if item.get_closest_marker(tier) is None:
            item.add_marker(tier)
        if item.get_closest_marker(GROUP) is None:
            item.add_marker(pytest.mark.xdist_group(group_of(item)))
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


def group_of(item: pytest.Item) -> str:
    """What runs on one worker: a module, for its fixtures' sake; but each session of ``tests/system`` for itself."""
    if item.get_closest_marker("alone") is not None:
        return "alone"
    if item.path.is_relative_to(HERE / "system") and not shares_a_fixture(item):
        return item.nodeid
    return f"{item.path.relative_to(HERE)}"


def shares_a_fixture(item: pytest.Item) -> bool:
    """Whether a fixture of its module, set up once, is one of those that it takes."""
    info = getattr(item, "_fixtureinfo", None)
    definitions = chain.from_iterable(info.name2fixturedefs.values()) if info else ()
    return any(d.scope in ("module", "class") for d in definitions)


def longest_first(items: Sequence[pytest.Item]) -> list[pytest.Item]:
    """Sessions and nodes in turn, as the ones compute and the others mostly wait; unit tests fill up what is left."""
    groups: dict[str, dict[str, list[pytest.Item]]] = {name: {} for name in TIERS}
    # A module of two tiers is one group: it goes by the higher.
    tier_of_group: dict[str, str] = {}
    for item in items:
        tier, group = tier_of(item), group_name(item)
        known = tier_of_group.get(group, tier)
        tier_of_group[group] = max(tier, known, key=list(TIERS).index)
    for item in items:
        group = group_name(item)
        groups[tier_of_group[group]].setdefault(group, []).append(item)
    nodes, sessions = list(groups["node"].values()), list(groups["system"].values())
    both = [g for pair in zip_longest(sessions, nodes) for g in pair if g is not None]
    in_order = [item for group in (*both, *groups["unit"].values()) for item in group]
    # At the end nobody has to wait long for the others, nor they for it.
    return sorted(in_order, key=lambda item: group_name(item) == "alone")


def group_name(item: pytest.Item) -> str:
    """The group that the test is marked with."""
    marker = item.get_closest_marker(GROUP)
    assert marker is not None
    return str(marker.args[0])


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Under xdist, have tests wait for one that is to run alone, and that one for them."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return (yield)
    alone = item.get_closest_marker("alone") is not None
    # Any two files that all workers have.
    with (HERE / "conftest.py").open() as gate, (HERE / "tiers.py").open() as room:
        # Whoever is to be alone keeps the gate closed until he leaves; the others only pass it.
        fcntl.flock(gate, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        fcntl.flock(room, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        if not alone:
            fcntl.flock(gate, fcntl.LOCK_UN)
        return (yield)


@pytest.fixture(autouse=True)
def _no_ros_in_unit_tests(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A unit test that opens ROS belongs to another tier, and fails."""
    if request.node.get_closest_marker("unit") is not None:

        def refuse(*_words: object, **_options: object) -> None:
            pytest.fail("a test of tier unit opened a ROS context: mark it pytest.mark.node (see tests/tiers.py)")

        monkeypatch.setattr(rclpy.Context, "init", refuse)
    yield
