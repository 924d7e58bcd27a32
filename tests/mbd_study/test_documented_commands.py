"""Every command that the pages recommend is there, with the options they give it."""

from __future__ import annotations

import re
import shlex
from importlib import import_module
from inspect import getsource
from pathlib import Path

import pytest
from mbd_bag.recorder.parameters import RECORDER

ROOT = Path(__file__).resolve().parents[2]
PAGES = (
    "docs/study.md",
    "docs/reproduction.md",
    "docs/mapping.md",
    "docs/execution.md",
    "docs/trials.md",
    "docs/perception.md",
    "docs/reliability.md",
    "bags/README.md",
)
# Where a command's options are declared, if not in the module of its entry point.
SHARED = "mbd_experiments.user_study.experiment_command"
DECLARED = {"experiment2": SHARED, "experiment3": SHARED}
PACKAGES = ("mbd_bag", "mbd_study", "mbd_experiments")


def entry_points() -> dict[str, str]:
    setups = "".join((ROOT / "ros2_ws" / "src" / p / "setup.py").read_text() for p in PACKAGES)
    return dict(re.findall(r'"(\w+) = ([\w.]+):main"', setups))


def commands() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        for line in (ROOT / page).read_text().splitlines():
            found += [(page, text) for text in re.findall(rf"\./mbd run (?:{'|'.join(PACKAGES)}) ([^`#]*)", line)]
    return found


@pytest.mark.parametrize(("page", "text"), commands())
def test_a_documented_command_is_there_with_its_options(page: str, text: str):
    name, *words = shlex.split(text.replace("[", "").replace("]", ""))
    module = entry_points()[name]
    if "--ros-args" in words:
        RECORDER.refuse_unknown(w.partition(":=")[0] for w in words if ":=" in w)
        return
    source = getsource(import_module(DECLARED.get(name, module)))
    if "add_executor_options(" in source:
        source += getsource(import_module("mbd_model.parallel.options"))
    for option in (w for w in words if w.startswith("--")):
        assert f'"{option}"' in source, f"{page}: {name} has no {option}"


def test_every_command_is_documented():
    pages = "".join((ROOT / page).read_text() for page in PAGES)
    wanted = {name: module.partition(".")[0] for name, module in entry_points().items()}
    assert [n for n, package in wanted.items() if not re.search(rf"(?:{package} |`){n}\b", pages)] == []
