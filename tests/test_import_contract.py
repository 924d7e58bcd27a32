"""What may import what (.importlinter): kept by the sources, broken by what it forbids."""

from __future__ import annotations

import configparser
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# A unit test by what it needs; each reads all sources, and `make lint` holds the contract besides.
pytestmark = pytest.mark.node

ROOT = Path(__file__).resolve().parents[1]
SRC = ROOT / "ros2_ws" / "src"
CONTRACT = ROOT / ".importlinter"
PACKAGES = sorted(p.name for p in SRC.iterdir() if (p / p.name / "__init__.py").exists())


def lint(src: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(str(src / name) for name in PACKAGES)
    # The path of the environment comes after: what is checked is this source tree, whatever is installed.
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((path, os.environ.get("PYTHONPATH", "")))}
    program = "from importlinter.cli import lint_imports_command as main; main()"
    words = [sys.executable, "-c", program, str(CONTRACT), "--no-cache", "--no-logo"]
    return subprocess.run(words, cwd=src, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    for name in PACKAGES:
        shutil.copytree(SRC / name / name, tmp_path / name / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def test_the_sources_keep_the_contract():
    done = lint(SRC)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_contract_is_about_every_package():
    contract = configparser.ConfigParser()
    contract.read(CONTRACT)
    assert sorted(contract["importlinter"]["root_packages"].split()) == PACKAGES
    layers = contract["importlinter:contract:layers"]["layers"].replace("|", " ").split()
    assert sorted(layers) == PACKAGES


@pytest.mark.parametrize(
    ("module", "line", "broken"),
    [
        ("mbd_mapping/strategy.py", "import rclpy", "Nothing outside ros/ imports rclpy or messages"),
        ("mbd_model/objects.py", "from mbd_msgs.msg import Scene", "Nothing outside ros/ imports rclpy or messages"),
        ("mbd_cell/stage.py", "import ament_index_python", "Outside ros/ one module asks where packages are installed"),
        ("mbd_model/objects.py", "import mbd_model.ros.conversions", "Only commands"),
        ("mbd_console/page.py", "import mbd_cell.cell", "Only the experiments and bringup know the simulated cell"),
        (
            "mbd_study/tables/info.py",
            "import mbd_cell.cell",
            "Only the experiments and bringup know the simulated cell",
        ),
        ("mbd_execution/plan.py", "import mbd_perception.overlay", "Execution imports the demonstration only"),
        ("mbd_console/page.py", "import mbd_mapping.mbd", "The console imports the interaction and perception only"),
        ("mbd_study/tables/info.py", "import mbd_interaction.events", "The study imports bags"),
        ("mbd_perception/overlay.py", "import mbd_demonstration.config", "Packages lie in layers"),
        ("mbd_cell/stage.py", "import mbd_experiments.csv_table", "Packages lie in layers"),
        ("mbd_perception/frames/frame.py", "import mbd_perception.features.box", "Perception goes from frames"),
        ("mbd_perception/features/box.py", "import mbd_perception.synthetic.paint", "Perception does not see with"),
    ],
)
def test_an_import_that_is_forbidden_breaks_it_even_inside_a_function(
    copied: Path, module: str, line: str, broken: str
) -> None:
    file = copied / module.partition("/")[0] / module
    file.write_text(file.read_text() + f"\n\ndef _planted() -> None:\n    {line}\n")
    done = lint(copied)
    kept = [text.strip() for text in " ".join(done.stdout.split()).replace("BROKEN", "BROKEN\n").split("\n")]
    assert done.returncode == 1, done.stdout + done.stderr
    assert any(broken in text and text.endswith("BROKEN") for text in kept), done.stdout
