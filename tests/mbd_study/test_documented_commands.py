"""Every command that the study's pages tell to run is there, with the options they give it."""

from __future__ import annotations

import re
import shlex
from importlib import import_module
from inspect import getsource
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("docs/study.md", "docs/reproduction.md", "bags/README.md")
# Where a command's options are declared, if not in the module of its entry point.
DECLARED = {"experiment2": "experiments.experiment_command", "experiment3": "experiments.experiment_command"}


def entry_points() -> dict[str, str]:
    setup = (ROOT / "ros2_ws" / "src" / "mbd_study" / "setup.py").read_text()
    return dict(re.findall(r'"(\w+) = mbd_study\.([\w.]+):main"', setup))


def commands() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        for line in (ROOT / page).read_text().splitlines():
            found += [(page, text) for text in re.findall(r"\./mbd run mbd_study ([^`#]*)", line)]
    return found


@pytest.mark.parametrize(("page", "text"), commands())
def test_a_documented_command_is_there_with_its_options(page: str, text: str):
    name, *words = shlex.split(text.replace("[", "").replace("]", ""))
    module = entry_points()[name]
    if "--ros-args" in words:
        declared = getsource(import_module("mbd_bag.ros.recorder_parameters"))
        parameters = [w.partition(":=")[0] for w in words if ":=" in w]
        assert all(f'"{p}"' in declared for p in parameters), parameters
        return
    source = getsource(import_module(f"mbd_study.{DECLARED.get(name, module)}"))
    for option in (w for w in words if w.startswith("--")):
        assert f'"{option}"' in source, f"{page}: {name} has no {option}"


def test_every_command_is_documented():
    pages = "".join((ROOT / page).read_text() for page in PAGES)
    assert [name for name in entry_points() if f"mbd_study {name}" not in pages] == []
