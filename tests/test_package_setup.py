"""package_setup installs a package with all that belongs to it, wherever and however its setup.py is run."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.system

SRC = Path(__file__).resolve().parents[1] / "ros2_ws" / "src"
PACKAGE = SRC / "mbd_cell"


def run(*command: str | Path, folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_setup_py_may_be_run_from_another_folder(tmp_path: Path):
    assert run(sys.executable, PACKAGE / "setup.py", "--name", folder=tmp_path).split() == ["mbd_cell"]


def test_a_source_distribution_can_be_built_where_the_workspace_is_not(tmp_path: Path):
    made = ("egg_info", "--egg-base", tmp_path, "sdist", "--dist-dir", tmp_path)
    run(sys.executable, "setup.py", "--quiet", *made, folder=PACKAGE)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as tar:
        tar.extractall(tmp_path, filter="data")
    unpacked = tmp_path / archive.name.removesuffix(".tar.gz")
    run(sys.executable, "setup.py", "--quiet", "build", "--build-base", tmp_path / "build", folder=unpacked)
    built = tmp_path / "build" / "lib" / "mbd_cell"
    assert {f.relative_to(built) for f in built.rglob("*.py")} == {
        f.relative_to(PACKAGE / "mbd_cell") for f in (PACKAGE / "mbd_cell").rglob("*.py")
    }
    for folder in ("config", "resource"):
        assert {f.name for f in (unpacked / folder).iterdir()} == {f.name for f in (PACKAGE / folder).iterdir()}


@pytest.mark.parametrize("how", [[], ["--symlink-install"]], ids=["copied", "linked"])
def test_colcon_installs_modules_data_and_executables(tmp_path: Path, how: list[str]):
    command = [sys.executable, "-m", "colcon", "--log-base", tmp_path / "log", "--log-level", "error", "build", *how]
    where = ["--base-paths", PACKAGE, "--build-base", tmp_path / "build", "--install-base", tmp_path / "install"]
    run(*command, *where, folder=tmp_path)
    prefix = tmp_path / "install" / "mbd_cell"
    share = prefix / "share"
    assert (share / "ament_index" / "resource_index" / "packages" / "mbd_cell").exists()
    assert (share / "mbd_cell" / "package.xml").exists()
    assert {f.name for f in (share / "mbd_cell" / "config").iterdir()} == {
        f.name for f in (PACKAGE / "config").iterdir() if f.is_file()
    }
    executable = prefix / "lib" / "mbd_cell" / "cell"
    assert os.access(executable, os.X_OK)
    assert executable.read_text().startswith(f"#!{sys.executable}")
    show = "source install/local_setup.bash && python3 -c 'import mbd_cell; print(mbd_cell.__file__)'"
    imported = Path(run("bash", "-c", show, folder=tmp_path).splitlines()[-1])
    assert imported.is_relative_to(tmp_path)
    assert (imported.parent / "py.typed").exists()
