"""The tests run where a normal ROS 2 install's pytest plugins, made for an older pytest, are on the path."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.system

ROOT = Path(__file__).resolve().parents[1]
FILE = "tests/mbd_model/test_spatial.py"


@pytest.fixture
def with_launch_testing(tmp_path: Path) -> dict[str, str]:
    """An environment that has what Jazzy's launch_testing and launch_testing_ros declare: hooks pytest 9 refuses."""
    for name, hook in {
        "launch_testing": "def pytest_pycollect_makemodule(path, parent): return None",
        "launch_testing_ros": "def pytest_launch_collect_makemodule(module_path, parent, entrypoint): return None",
    }.items():
        (tmp_path / f"{name}_entrypoint.py").write_text(f"{hook}\n")
        metadata = tmp_path / f"{name}-3.4.3.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 3.4.3\n")
        (metadata / "entry_points.txt").write_text(f"[pytest11]\n{name} = {name}_entrypoint\n")
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    left_out = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD", "PYTEST_ADDOPTS", "PYTEST_XDIST_WORKER"}
    return {**{k: v for k, v in os.environ.items() if k not in left_out}, "PYTHONPATH": path}


def collect(environment: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytest", "--collect-only", "-p", "no:cacheprovider", *words, FILE]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


def test_collection_does_not_load_them(with_launch_testing: dict[str, str]):
    done = collect(with_launch_testing)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{FILE}::" in done.stdout


def test_they_are_on_the_path_and_would_stop_collection(with_launch_testing: dict[str, str]):
    done = collect(with_launch_testing, "-o", "addopts=--import-mode=importlib")
    assert done.returncode != 0
    assert "pytest_pycollect_makemodule" in done.stdout + done.stderr
