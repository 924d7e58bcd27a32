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
from mbd_model.ros.starting.command_line import parameter_files, refuse_parameter_file

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


def ended(module: str, function: str, monkeypatch: pytest.MonkeyPatch, *words: str) -> object:
    """The exit code of an entry point that is called with these words; its text where that is a sentence."""
    monkeypatch.setattr(sys, "argv", ["/usr/bin/it", *words])
    try:
        # As the installed script does, which exits with what it returns.
        return getattr(importlib.import_module(module), function)()
    except SystemExit as end:
        return end.code


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


# What a person types that means nothing, for one executable or another; {} is a folder with a text file in it.
MISTAKES = {
    "a bag that is not there": ["no-such-bag"],
    "two words too many": ["no-such-bag", "another", "third"],
    "a text file for a bag": ["{}/file.txt"],
    "bytes for a bag": ["{}/bytes.yaml"],
    "a folder without bags": ["{}"],
    "an option without its value": ["no-such-bag", "--out"],
    "a place that cannot be": ["no-such-bag", "--out", "/proc/1/no/such"],
    "an empty word": [""],
    "a word of launch": ["sede:=3"],
    "a word for a number": ["no-such-bag", "--seed", "three", "--jobs", "many"],
    "no parallel process": ["no-such-bag", "--jobs", "0"],
    "a parameter file that is not there": ["--ros-args", "--params-file", "/no/such.yaml"],
    "a parameter file of bytes": ["--ros-args", "--params-file", "{}/bytes.yaml"],
    "a parameter file without sections": ["--ros-args", "--params-file", "{}/list.yaml"],
    "a parameter file that is no YAML": ["--ros-args", "--params-file", "{}/broken.yaml"],
}


# Their word is a folder that they make: what is no bag is no mistake to them.
MAKES_ITS_FOLDER = {
    "mbd_experiments rehearse_study",
    "mbd_experiments simulate_study",
    "mbd_bag repair_trials",
    "mbd_bag mutation_trials",
}
NO_BAG = ("a bag that is not there", "a folder without bags", "an empty word", "a word of launch")


@pytest.mark.parametrize("name", EXECUTABLES)
def test_fifteen_mistakes_are_each_said_in_a_sentence_and_end_the_command(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    folder, work = tmp_path / "given", tmp_path / "work"
    folder.mkdir()
    work.mkdir()
    (folder / "file.txt").write_text("no bag\n")
    (folder / "bytes.yaml").write_bytes(b"\xff\xfe\x00\x01")
    (folder / "list.yaml").write_text("- 1\n")
    (folder / "broken.yaml").write_text("a: [1,\n b: : 2")
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    monkeypatch.chdir(work)
    for mistake, words in MISTAKES.items():
        if name in MAKES_ITS_FOLDER and mistake in NO_BAG:
            continue
        code = ended(*EXECUTABLES[name], monkeypatch, *(word.replace("{}", str(folder)) for word in words))
        said = capfd.readouterr()
        text = f"{said.out}{said.err}{code if isinstance(code, str) else ''}"
        assert code not in (0, None), f"{name}, {mistake}: {text}"
        assert text.strip(), f"{name}, {mistake}"
        assert "Traceback" not in text, f"{name}, {mistake}: {text}"
        assert len(text.splitlines()) < 60, f"{name}, {mistake}: {text}"
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before
    assert not list(work.iterdir()), f"{name} left something behind"


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"- 1\n", "has no section of parameters"),
        (b"", "has no section of parameters"),
        (b"seed: 3\n", "has no section of parameters"),
        (b"a: [1,\n b: : 2", "is no YAML"),
        (b"\xff\xfe\x00\x01", "is no YAML"),
    ],
)
def test_a_parameter_file_that_sets_nothing_is_refused_with_how_one_looks(content: bytes, why: str, tmp_path: Path):
    path = tmp_path / "given.yaml"
    path.write_bytes(content)
    assert parameter_files(["x", "--params-file", "no", "--ros-args", "--params-file", str(path), "--", "y"]) == [path]
    with pytest.raises(MbdError, match=f"{path} {why}.*ros__parameters"):
        refuse_parameter_file(path)


def test_every_parameter_file_of_ours_is_taken():
    files = [p for p in ROOT.glob("ros2_ws/src/*/config/*.yaml") if "ros__parameters" in p.read_text(encoding="utf-8")]
    assert len(files) > 3
    for path in files:
        refuse_parameter_file(path)


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
