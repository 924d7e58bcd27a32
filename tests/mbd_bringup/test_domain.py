"""Private ROS domains, as tests and sessions side by side take them."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from mbd_bringup.domain import FIRST, LAST, private_domain
from mbd_model.errors import MbdError

TAKES = """
import sys
from mbd_bringup.domain import private_domain
with private_domain() as domain:
    print(domain, flush=True)
    sys.stdin.readline()
"""


@pytest.fixture
def locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the locks of these tests lie: taking every domain must stop no other test."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    return tmp_path


@pytest.fixture
def takers(locks: Path) -> Iterator[list[subprocess.Popen[str]]]:
    """Processes that ask for a domain at once, and keep it until they are released or killed."""
    assert locks
    command = [sys.executable, "-c", TAKES]
    started = [subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) for _ in range(8)]
    yield started
    for process in started:
        process.kill()
        process.communicate()


def taken_by(process: subprocess.Popen[str]) -> int:
    assert process.stdout is not None
    return int(process.stdout.readline())


def test_processes_that_ask_at_the_same_time_get_domains_of_their_own(takers: list[subprocess.Popen[str]]):
    domains = [taken_by(process) for process in takers]
    assert len(set(domains)) == len(takers)
    assert all(FIRST <= domain <= LAST for domain in domains)


def test_the_domain_of_a_killed_process_is_free_again_and_no_other(takers: list[subprocess.Popen[str]]):
    domains = [taken_by(process) for process in takers]
    takers[0].kill()
    takers[0].wait()
    with ExitStack() as stack:
        free = {stack.enter_context(private_domain()) for _ in range(LAST + 1 - FIRST - len(takers) + 1)}
        assert free == set(range(FIRST, LAST + 1)) - set(domains[1:])


def test_when_all_are_taken_the_error_states_what_to_do(locks: Path):
    assert locks
    with ExitStack() as stack:
        for _ in range(FIRST, LAST + 1):
            stack.enter_context(private_domain())
        with pytest.raises(MbdError, match="end a session or test that is still running"), private_domain():
            pass


def test_the_one_free_longest_is_taken_next(locks: Path):
    assert locks
    seen = []
    for _ in range(FIRST, LAST + 1):
        with private_domain() as domain:
            seen.append(domain)
    assert sorted(seen) == list(range(FIRST, LAST + 1))
    with private_domain() as domain:
        assert domain == seen[0]


def test_a_link_in_place_of_a_lock_is_refused_and_its_target_left_as_it_was(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    target = tmp_path / "diary"
    target.write_text("dear diary")
    os.utime(target, ns=(5, 5))
    with private_domain() as domain:
        pass
    (folder,) = (f for f in tmp_path.iterdir() if f.is_dir())
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    for number in range(FIRST, LAST + 1):
        (folder / str(number)).unlink(missing_ok=True)
        (folder / str(number)).symlink_to(target)
    with pytest.raises(MbdError, match="remove it"), private_domain():
        pass
    assert (target.read_text(), target.stat().st_mtime_ns) == ("dear diary", 5)
    assert FIRST <= domain <= LAST


@pytest.mark.parametrize("kind", ["link", "file"])
def test_a_folder_of_locks_that_is_none_of_this_user_is_refused(kind, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    folder, elsewhere = tmp_path / f"mbd_ros_domains_{os.getuid()}", tmp_path / "elsewhere"
    elsewhere.mkdir()
    if kind == "link":
        folder.symlink_to(elsewhere)
    else:
        folder.touch()
    with pytest.raises(MbdError, match="not a folder of this user"), private_domain():
        pass
    assert list(elsewhere.iterdir()) == []
