"""The demo states at once what it cannot use, and ends with a word whenever it is interrupted."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from datetime import datetime

import pytest
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.demo_session import parse_arguments, session_options
from mbd_model.errors import MbdError

# The interpreter imports for seconds before the demo's own code runs: interrupted there, at the first import of all.
INTERRUPTED = """
import os, signal, sys
from mbd_bringup.demo_command import main

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == "rich.console":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
main()
"""


def options(*words: str) -> SessionOptions:
    """What the demo makes of these words."""
    return session_options(parse_arguments(words), datetime(2026, 11, 26, 9, 30))


def test_interrupted_while_it_is_still_being_imported_it_reports_it():
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (128 + signal.SIGINT, "demo: interrupted before anything was started\n")


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--seed", "-3"), "--seed: -3 is too few"),
        (("--threshold", "1.5"), "--threshold: 1.5 is not from 0 to 1"),
        (("--speed", "nan"), "--speed: 'nan' is no finite number"),
    ],
)
def test_an_option_out_of_its_range_is_refused_by_name(words, why, tmp_path, capsys):
    with pytest.raises(SystemExit):
        options("--out", str(tmp_path / "new"), *words)
    assert why in capsys.readouterr().err


def test_a_speed_beyond_the_cell_is_refused(tmp_path):
    with pytest.raises(MbdError, match=re.escape("speed 5000 is not in 0..1000")):
        options("--out", str(tmp_path / "new"), "--speed", "5000")


def test_a_folder_that_holds_a_session_is_left_alone(tmp_path):
    (tmp_path / "kept").touch()
    with pytest.raises(MbdError, match="give another --out"):
        options("--out", str(tmp_path))


def test_a_session_is_named_by_its_task_seed_and_time(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = options("--task", "stacking", "--seed", "3")
    assert made.session == "stacking_seed3_20261126_093000"
    assert made.folder == tmp_path / "sessions" / made.session
