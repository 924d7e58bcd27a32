"""Whole sessions as separate processes in the simulated cell, recorded and replayed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from pathlib import Path

import pytest
from mbd_bag.session.recorded_session import RecordedReply
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.follow import SessionEvent
from mbd_bringup.ros.live_session import LiveSession, install_prefixes
from mbd_model.estimate import MappingEstimate
from mbd_model.ros.qos import EVENTS
from mbd_model.session import Phase, Prompt, PromptKind
from mbd_msgs.msg import WizardCommand, WizardHanded

pytestmark = pytest.mark.timeout(600)


def tool(package: str, executable: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run one of our command-line tools."""
    path = install_prefixes([package])[package] / "lib" / package / executable
    return subprocess.run([str(path), *words], capture_output=True, text=True, check=False, timeout=300)


def is_estimate(event: SessionEvent | None, assists: int) -> bool:
    """Whether it is an estimate from so many assists."""
    return event is not None and isinstance(event.fact, MappingEstimate) and event.fact.num_assists == assists


@pytest.mark.parametrize("words", [("--task=stacking", "--seed=2"), ("--task=sorting", "--seed=3", "--no-execute")])
def test_the_demo_finds_the_right_mapping_and_its_bag_replays_to_equal_estimates(
    words: tuple[str, ...], tmp_path: Path
):
    out = tmp_path / "session"
    done = tool("mbd_bringup", "demo", *words, "--out", str(out))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "agrees" in done.stdout
    table = tool("mbd_study", "table", str(out / "bag"))
    last = [line for line in table.stdout.splitlines() if re.search(r"\b(right|wrong)\b", line)][-1]
    assert "right" in last, table.stdout
    assert (out / "mapping.png").stat().st_size > 10_000
    assert (out / "bag" / "metadata.yaml").exists()


def test_a_mapping_node_killed_and_restarted_amid_the_assists_loses_nothing(tmp_path: Path):
    # No confidence reaches 1, so every step is asked about and there is an assist loop to kill the node in.
    options = SessionOptions("killed", tmp_path / "killed", task="sorting", seed=1, threshold=1.0, speed=0.0)
    killed = told_last = False
    with LiveSession(options) as live:
        for event in live.events(timeout=300):
            told_last = told_last or is_estimate(event, assists=6)
            if not killed and is_estimate(event, assists=2):
                live.processes.restart("mapping")
                killed = True
        assert live.phase is Phase.DONE
        # The dialogue asks on only once it has the estimate of its present assists, so every later assist proves the
        # restarted node. This follower may meet that node later than the dialogue does, but the last word is latched.
        while not told_last:
            told_last = is_estimate(live.follower.events.get(timeout=60), assists=6)
        assert live.processes.stop(patience=20) == []
    assert killed
    replayed = tool("mbd_study", "replay", str(options.bag), "--check")
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


def test_every_node_of_the_method_and_the_recorder_can_be_killed_once_and_the_session_still_ends_well(tmp_path: Path):
    options = SessionOptions("killed", tmp_path / "killed", task="stacking", seed=1, threshold=1.0, speed=0.0)
    # The node to kill when this phase is entered, that is, just after it did the work of the phase before.
    victims = {
        Phase.DEMONSTRATE: "perception",
        Phase.TUCK_AND_CLEAR: "demonstration",
        Phase.OBSERVE_TARGET: "recorder",
        Phase.ASSIST: "interaction",
    }
    killed = set()
    with LiveSession(options) as live:
        for event in live.events(timeout=300):
            victim = victims.get(event.phase) if event is not None and event.phase is not None else None
            if victim is not None and victim not in killed:
                live.processes.restart(victim)
                killed.add(victim)
        assert live.phase is Phase.DONE
        assert live.processes.stop(patience=20) == []
    assert killed == set(victims.values())
    replayed = tool("mbd_study", "replay", str(options.bag), "--check")
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


def test_wrong_wizard_events_are_refused_with_a_reason_and_change_nothing(tmp_path: Path):
    options = SessionOptions("wrong", tmp_path / "wrong", task="stacking", seed=2, speed=0.0)
    refused = []
    with LiveSession(options) as live:
        handed = live.follower.create_publisher(WizardHanded, "wizard/handed", EVENTS)
        command = live.follower.create_publisher(WizardCommand, "wizard/command", EVENTS)
        for event in live.events(timeout=300):
            if event is None:
                continue
            if event.phase is Phase.DEMONSTRATE:
                handed.publish(WizardHanded(object_id="t1"))  # nothing was asked yet
                command.publish(WizardCommand(command=99))  # no such command
            elif event.phase is Phase.OBSERVE_TARGET:
                command.publish(WizardCommand(command=WizardCommand.UNDO))  # there is no assist to withdraw
            elif isinstance(event.fact, Prompt) and event.fact.kind is PromptKind.WHAT_DO_I_USE:
                handed.publish(WizardHanded(object_id="teapot"))  # no such object
            elif isinstance(event.fact, RecordedReply) and not event.fact.accepted:
                refused.append(event.fact.reason)
        assert live.phase is Phase.DONE
        assert live.processes.stop(patience=20) == []
    assert len(refused) >= 4, refused
    assert any("teapot" in text and "t1" in text for text in refused), refused
    assert tool("mbd_study", "replay", str(options.bag), "--check").returncode == 0


def test_ctrl_c_amid_the_demonstration_ends_every_node_and_leaves_a_readable_bag(tmp_path: Path):
    out = tmp_path / "session"
    path = install_prefixes(["mbd_bringup"])["mbd_bringup"] / "lib" / "mbd_bringup" / "demo"
    demo = subprocess.Popen(
        [str(path), "--task", "stacking", "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    lines = []
    for line in demo.stdout:
        lines.append(line)
        if "close" in line and "teacher" in line:
            demo.send_signal(signal.SIGINT)
            break
    rest, _ = demo.communicate(timeout=60)
    assert demo.returncode == 130, "".join(lines) + rest
    assert "interrupted" in rest
    left = subprocess.run(["pgrep", "-f", str(out)], capture_output=True, text=True, check=False).stdout
    assert left == "", f"still running: {left}"
    info = tool("mbd_study", "info", str(out / "bag"))
    assert info.returncode == 0, info.stdout + info.stderr
