"""Where this checkout cannot be set up, it is refused at once with the reason and what to do; nothing is made."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOBODY = 65534
Place = Callable[[str], Path]


@pytest.fixture
def place() -> Iterator[Place]:
    """Make a copy of what set-up is started with, in a folder of the given name that every user may enter."""
    made = Path(tempfile.mkdtemp(prefix="mbd_places_"))
    made.chmod(0o755)

    def copy(name: str) -> Path:
        folder = made / name
        folder.mkdir(parents=True)
        for file in ("Makefile", "mbd", "env.sh"):
            shutil.copy2(ROOT / file, folder)
        for part in ("tools", "requirements"):
            shutil.copytree(ROOT / part, folder / part)
        return folder

    yield copy
    shutil.rmtree(made)


def put_on_path(folder: Path, name: str, script: str) -> str:
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(f"#!/bin/sh\n{script}\n")
    (folder / name).chmod(0o755)
    return f"{folder}:{os.environ['PATH']}"


def run(*command: str | Path, user: int | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    left_out = ("PIP_", "MAKE", "MFLAGS", "MBD_ROS")
    inherited = {k: v for k, v in os.environ.items() if not k.startswith(left_out)}
    return subprocess.run(
        command,
        env={**inherited, "MBD_ROS": "wheels", **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        **({} if user is None else {"user": user, "group": user, "extra_groups": []}),
    )


@pytest.fixture
def python(place: Place) -> str:
    """A PATH with a python3 that any user may start; root's own may lie where no other user can look."""
    return put_on_path(place("elsewhere") / "bin", "python3", "echo 312")


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("a b", "has a space in it"),
        ("a\tb", "has a tab in it"),
        ("a:b", "has ':' in it"),
        ("cost$", "has '$' in it"),
        ("it's", "has ''' in it"),
        ("x" * 120 + "/" + "y" * 120, "characters long"),
    ],
)
@pytest.mark.parametrize("target", ["demo", "test", "check", "build"])
def test_a_folder_name_in_which_generated_scripts_break_is_refused(place: Place, name: str, reason: str, target: str):
    folder = place(name)
    done = run("make", "-C", folder, target)
    assert done.returncode != 0
    assert reason in done.stderr
    assert "move" in done.stderr
    assert not (folder / ".venv").exists()


@pytest.mark.parametrize("name", ["plain", "a.b-c_d+e@f,g=h~1%", "Müller/工作"])
def test_a_folder_name_in_which_they_work_is_accepted(place: Place, name: str):
    done = run(place(name) / "tools" / "check-place")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(("number", "version"), [(310, "3.10.12"), (208, "2.8.0"), (399, "3.99.0")])
def test_a_python_without_the_wheels_is_refused_with_its_version_and_place(
    place: Place, tmp_path: Path, number: int, version: str
):
    folder = place("plain")
    path = put_on_path(tmp_path / "bin", "python3", f'[ "$1" = --version ] && echo "Python {version}" || echo {number}')
    done = run("make", "-C", folder, "demo", PATH=path)
    assert done.returncode != 0
    assert f"Python 3.11 to 3.14 is needed; python3 here is Python {version} ({tmp_path}/bin/python3)" in done.stderr
    assert not (folder / ".venv").exists()


def test_a_newer_python_is_taken_with_a_systems_ros(place: Place, tmp_path: Path):
    path = put_on_path(tmp_path / "bin", "python3", "echo 399")
    assert run(place("plain") / "tools" / "check-place", PATH=path, MBD_ROS="native").returncode == 0


def test_a_read_only_checkout_is_refused(place: Place, python: str):
    folder = place("plain")
    folder.chmod(0o555)
    user = NOBODY if os.getuid() == 0 else None
    done = run(folder / "tools" / "setup", user=user, PATH=python)
    folder.chmod(0o755)
    assert done.returncode == 1
    assert "cannot be written to" in done.stderr
    assert "clone it to a folder of your own" in done.stderr


@pytest.mark.parametrize("part", [".venv", ".venv/lib/python3.12/site-packages", "ros2_ws/install", "ros2_ws/build"])
def test_what_another_user_has_set_up_is_refused_with_the_command_that_mends_it(place: Place, python: str, part: str):
    folder = place("plain")
    (folder / part).mkdir(parents=True)
    if os.getuid() == 0:
        for owned in (folder, *(folder / part).parents):
            if owned.is_relative_to(folder):
                os.chown(owned, NOBODY, NOBODY)
    (folder / part).chmod(0o555)
    done = run(folder / "tools" / "setup", user=NOBODY if os.getuid() == 0 else None, PATH=python)
    assert done.returncode == 1
    assert f"{part} belongs to" in done.stderr
    assert "sudo chown -R" in done.stderr


def test_a_full_disk_is_refused_with_what_is_needed_and_what_is_free(place: Place, tmp_path: Path):
    lines = "Filesystem 1024-blocks Used Available Capacity Mounted on\\n/dev/vda 9000000 8795200 204800 98%% /"
    path = put_on_path(tmp_path / "bin", "df", f"printf '{lines}\\n'")
    done = run(place("plain") / "tools" / "setup", PATH=path)
    assert done.returncode == 1
    assert "needs 3000 MB on the disk" in done.stderr
    assert "200 MB are free" in done.stderr


def test_without_a_network_the_reason_is_reported_and_nothing_is_made(place: Place):
    folder = place("plain")
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        port = closed.getsockname()[1]
    index = {"PIP_CONFIG_FILE": os.devnull, "PIP_INDEX_URL": f"http://127.0.0.1:{port}/simple"}
    done = run(folder / "tools" / "setup", **index)
    assert done.returncode == 1
    assert "is there a network, does it need a proxy?" in done.stderr
    assert "Connection refused" in done.stderr
    assert not (folder / ".venv").exists()


def test_a_checkout_that_was_moved_states_so_in_place_of_running_the_old_one(place: Place):
    folder = place("plain")
    executable = folder / "ros2_ws" / "install" / "mbd_cell" / "lib" / "mbd_cell" / "cell"
    executable.parent.mkdir(parents=True)
    executable.write_text("#!/bin/sh\necho started\n")
    executable.chmod(0o755)
    (folder / "ros2_ws" / "install" / "setup.bash").touch()
    (folder / ".venv").mkdir()
    (folder / ".venv" / ".mbd-kind").write_text(f"wheels Python 3.12.1 {folder}_before\n")
    done = run(folder / "mbd", "run", "mbd_cell", "cell")
    assert done.returncode == 1
    assert "built in another folder and then moved to this one; run: make build" in done.stderr
    assert "started" not in done.stdout


def test_a_shell_of_the_checkout_keeps_what_python_compiles_where_that_is_switched_off():
    """Else each of the hundreds of processes that the tests start compiles all that it imports."""
    script = 'source "$0" && python -c "import sys; print(sys.dont_write_bytecode)"'
    done = run("bash", "-c", script, ROOT / "env.sh", PYTHONDONTWRITEBYTECODE="1")
    assert done.stdout == "False\n", done.stderr


def test_nothing_is_refused_here():
    done = run(ROOT / "tools" / "check-place", "--to-write")
    assert (done.returncode, done.stderr) == (0, "")


def test_the_check_leaves_nothing_behind(place: Place):
    folder = place("plain")
    before = set(folder.rglob("*"))
    done = run(folder / "tools" / "check-place", "--to-write")
    assert (done.returncode, done.stderr) == (0, "")
    assert set(folder.rglob("*")) == before
