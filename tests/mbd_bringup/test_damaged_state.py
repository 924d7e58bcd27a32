"""A node whose state files are damaged, foreign or folders starts without them, says so, and keeps them aside."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from mbd_bringup.ros.hostile.hostile_messages import hostile_message
from mbd_console.restart.kept_console import KeptConsole
from mbd_console.ros.console_node import ConsoleNode
from mbd_demonstration.ros.node import DemonstrationNode
from mbd_execution.ros.node import ExecutionNode
from mbd_interaction.ros.node import InteractionNode
from mbd_model.errors import MbdError
from mbd_msgs.msg import Assists, Progress, Prompt, Scene, SessionState, Stop, Task
from mbd_perception.ros.node import PerceptionNode
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

# Of each node the files it keeps, with the message in them; None for another format.
KEPT: dict[type, dict[str, Any]] = {
    PerceptionNode: {"perception.source_scene.cdr": Scene, "perception.target_scene.cdr": Scene},
    DemonstrationNode: {"demonstration.task.cdr": Task, "demonstration.recording": None},
    InteractionNode: {
        "interaction.state.cdr": SessionState,
        "interaction.assists.cdr": Assists,
        "interaction.prompt.cdr": Prompt,
        "stop.cdr": Stop,
    },
    ExecutionNode: {"interaction.progress.cdr": Progress, "stop.cdr": Stop},
    ConsoleNode: {"console.json": None},
}
MORE = {InteractionNode: {"session": "s"}}


def started(kind: type, state: Path, domain: int) -> None:
    """The node starts, and ends."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    given = {"state_dir": str(state), **MORE.get(kind, {})}
    try:
        node = kind(context=context, parameter_overrides=[Parameter(k, value=v) for k, v in given.items()])
        node.destroy_node()
    finally:
        rclpy.try_shutdown(context=context)


def a_folder(path: Path) -> None:
    path.mkdir()
    (path / "content").write_text("of somebody")


DAMAGE: dict[str, Callable[[Path], object]] = {
    "garbage": lambda path: path.write_bytes(b"\xff\x00garbage\n" * 9),
    "empty": lambda path: path.write_bytes(b""),
    "nested": lambda path: path.write_bytes(b"[" * 200_000),
    "a folder": a_folder,
}


@pytest.mark.parametrize("kind", KEPT, ids=lambda kind: kind.__name__)
def test_what_cannot_be_read_is_set_aside_with_all_it_holds(kind: type, ros_domain: int, tmp_path: Path):
    for what, damage in DAMAGE.items():
        state = tmp_path / what
        state.mkdir()
        for name in KEPT[kind]:
            damage(state / name)
        started(kind, state, ros_domain)
        aside = sorted(p.name for p in state.iterdir() if ".broken" in p.name)
        assert aside == sorted(Path(name).with_suffix(".broken").name for name in KEPT[kind]), what
        if what == "a folder":
            assert all((state / name / "content").exists() for name in aside)


@pytest.mark.parametrize("kind", [k for k in KEPT if any(KEPT[k].values())], ids=lambda kind: kind.__name__)
def test_messages_that_make_no_sense_end_no_node_that_kept_them(kind: type, ros_domain: int, tmp_path: Path):
    rng = np.random.default_rng(3)
    for k in range(4):
        state = tmp_path / str(k)
        state.mkdir()
        for name, message in KEPT[kind].items():
            if message is not None:
                (state / name).write_bytes(bytes(serialize_message(hostile_message(message, rng))))
        started(kind, state, ros_domain)


@pytest.mark.parametrize("kind", KEPT, ids=lambda kind: kind.__name__)
def test_a_state_folder_that_cannot_be_written_is_refused_in_one_sentence(kind: type, ros_domain: int, tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(MbdError, match=r"state_dir .* cannot be used") as refused:
        started(kind, tmp_path / "file" / "state", ros_domain)
    assert "\n" not in str(refused.value)


def test_every_topic_that_is_kept_is_tried_here(ros_domain: int, tmp_path: Path):
    """A node that comes to keep another file has it tried, too."""
    source = Path(__file__).resolve().parents[2] / "ros2_ws" / "src"
    files = [p for p in source.glob("*/*/ros/**/*.py") if "LatchedPublisher(" in p.read_text()]
    owners = {p.parent.parent.name if p.parent.name == "ros" else p.parent.parent.parent.name for p in files}
    assert owners - {"mbd_model"} == {kind.__module__.split(".")[0] for kind in KEPT} - {"mbd_console"}


@pytest.mark.parametrize("text", ["{}", "[]", "null", '{"session": 1}', json.dumps({"began": "x"}), "[" * 100_000])
def test_a_file_that_no_console_kept_is_set_aside(text: str, tmp_path: Path):
    (tmp_path / "console.json").write_text(text)
    assert "moved to console.broken" in KeptConsole(tmp_path).set_aside_unreadable()
    assert KeptConsole(tmp_path).set_aside_unreadable() == ""
