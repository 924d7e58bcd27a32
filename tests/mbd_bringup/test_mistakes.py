"""What a person gets wrong on a command line: each is one sentence and a failing exit code, never a traceback.

Each executable's entry point is called here as its process would call it: with its words, up to where it ends.
"""

from __future__ import annotations

import importlib
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import pytest
from mbd_bringup.ros.demo_session import parse_arguments, session_options
from mbd_console.access.port import refuse_taken_port
from mbd_model.errors import MbdError

ROOT = Path(__file__).resolve().parents[2]
ENTRY = re.compile(r'"(\w+) = ([\w.]+):(\w+)"')
# Executable: its module and function.
EXECUTABLES = {
    f"{setup.parent.name} {name}": (module, function)
    for setup in sorted(ROOT.glob("ros2_ws/src/*/setup.py"))
    for name, module, function in ENTRY.findall(setup.read_text(encoding="utf-8"))
}


@pytest.fixture(autouse=True)
def undisturbed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An entry point takes the signals, and changes variables."""
    kept = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    monkeypatch.setattr(os, "environ", os.environ.copy())
    yield
    for number, handler in kept.items():
        signal.signal(number, handler)


def ended(module: str, function: str, monkeypatch: pytest.MonkeyPatch, words: str) -> object:
    """The exit code of an entry point that is called with this word; its text where that is a sentence."""
    monkeypatch.setattr(sys, "argv", ["/usr/bin/it", words])
    with pytest.raises(SystemExit) as end:
        getattr(importlib.import_module(module), function)()
    return end.value.code


@pytest.mark.parametrize("name", EXECUTABLES)
def test_help_is_printed_and_nothing_is_started(
    name: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    assert ended(*EXECUTABLES[name], monkeypatch, "--help") in (0, None)
    told = capfd.readouterr().out
    assert "usage" in told.lower() and len(told.splitlines()) > 3, name


@pytest.mark.parametrize("name", EXECUTABLES)
def test_an_option_that_is_none_is_refused_by_its_name(
    name: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    code = ended(*EXECUTABLES[name], monkeypatch, "--no-such-option")
    said = capfd.readouterr()
    text = f"{said.out}{said.err}{code}"
    assert code not in (0, None) and "Traceback" not in text, name
    assert "--no-such-option" in text or "required" in text, text


@pytest.mark.parametrize("place", ["/proc/1/no/such", "a file", "below a file"])
def test_a_place_that_cannot_hold_a_session_is_said_before_anything_starts(place: str, tmp_path: Path):
    file = tmp_path / "file"
    file.write_text("not a folder")
    out = {"a file": file, "below a file": file / "session"}.get(place, Path(place))
    with pytest.raises(MbdError, match=r"cannot hold a session .*: give a folder that this user may write"):
        session_options(parse_arguments(["--out", str(out)]), datetime(2026, 1, 1))
    assert file.read_text() == "not a folder"


@pytest.mark.parametrize("below", ["file", "file/bag"])
def test_a_recorder_that_cannot_write_its_bag_says_where_and_leaves_what_is_there(
    below: str, tmp_path: Path, ros_domain: int
):
    (tmp_path / "file").write_text("not a bag")
    environment = {**os.environ, "ROS_DOMAIN_ID": str(ros_domain)}
    start = "from mbd_bag.ros.recorder_node import main; main()"
    command = [sys.executable, "-c", start, "--ros-args", "-p", f"bag:={tmp_path / below}"]
    ended = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env=environment,
    )
    assert ended.returncode == 1 and "Traceback" not in ended.stderr
    assert str(tmp_path / below) in ended.stderr
    assert (tmp_path / "file").read_text() == "not a bag"


def test_a_port_in_use_is_said_and_one_that_was_left_is_taken():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(MbdError, match=f"cannot be served at 127.0.0.1:{port}: another program listens there"):
            refuse_taken_port("127.0.0.1", port)
    refuse_taken_port("127.0.0.1", port)


def test_a_port_that_is_none_is_refused_before_the_console_announces_itself(ros_domain: int):
    command = [sys.executable, "-m", "mbd_console.ros.main", "--ros-args", "-p", "port:=abc"]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(ros_domain)}
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, env=environment)
    said = ended.stdout + ended.stderr
    assert ended.returncode == 1 and "Traceback" not in said and "console at" not in said
    assert "port" in said
