"""Complete sessions as separate processes in the simulated cell, recorded and replayed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from mbd_bag.session.command_line import open_session
from mbd_bag.session.recorded_session import RecordedReply
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.follow import SessionEvent
from mbd_bringup.ros.live_session import LiveSession, install_prefixes
from mbd_model.estimate import MappingEstimate
from mbd_model.ros.qos import EVENTS
from mbd_model.session import Phase, Prompt, PromptKind
from mbd_msgs.msg import WizardCommand, WizardHanded
from mbd_study.tables.correctness import answers_of

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


@dataclass
class Disturbed:
    """A session in which every node of the method and the recorder were killed once and the wizard was wrong.

    Attributes:
        ended: the phase it ended in.
        killed: the nodes that were killed and started again.
        estimated_last: the last estimate, from all six assists, was received.
        refused: the reasons of the replies that refused something.
        hanging: nodes that did not end when they were asked to.
        replayed: what the replay of its bag gave.
    """

    ended: Phase | None = None
    killed: set[str] = field(default_factory=set)
    estimated_last: bool = False
    refused: list[str] = field(default_factory=list)
    hanging: Sequence[str] = ()
    replayed: subprocess.CompletedProcess[str] | None = None


# The node to kill when this phase is entered, that is, just after it did the work of the phase before.
VICTIMS = {
    Phase.DEMONSTRATE: "perception",
    Phase.TUCK_AND_CLEAR: "demonstration",
    Phase.OBSERVE_TARGET: "recorder",
    Phase.ASSIST: "interaction",
}


class WrongWizard:
    """States at certain moments what cannot be so, besides the wizard who does it right."""

    def __init__(self, live: LiveSession) -> None:
        self._handed = live.follower.create_publisher(WizardHanded, "wizard/handed", EVENTS)
        self._command = live.follower.create_publisher(WizardCommand, "wizard/command", EVENTS)

    def on_event(self, event: SessionEvent) -> None:
        """Publish something wrong, if this is the moment."""
        if event.phase is Phase.DEMONSTRATE:
            self._handed.publish(WizardHanded(object_id="t1"))  # nothing was asked yet
            self._command.publish(WizardCommand(command=99))  # no such command
        elif event.phase is Phase.OBSERVE_TARGET:
            self._command.publish(WizardCommand(command=WizardCommand.UNDO))  # there is no assist to withdraw
        elif isinstance(event.fact, Prompt) and event.fact.kind is PromptKind.WHAT_DO_I_USE:
            self._handed.publish(WizardHanded(object_id="teapot"))  # no such object


@pytest.fixture(scope="module")
def disturbed(tmp_path_factory: pytest.TempPathFactory) -> Disturbed:
    # No confidence reaches 1, so every step is asked about and there is an assist loop to kill nodes in.
    folder = tmp_path_factory.mktemp("disturbed") / "session"
    options = SessionOptions("disturbed", folder, task="sorting", seed=1, threshold=1.0, speed=0.0)
    made = Disturbed()
    with LiveSession(options) as live:
        wrong = WrongWizard(live)
        for event in live.events(timeout=300):
            if event is None:
                continue
            wrong.on_event(event)
            victim = VICTIMS.get(event.phase) if event.phase is not None else None
            if is_estimate(event, assists=2):
                victim = "mapping"
            if victim is not None and victim not in made.killed:
                live.processes.restart(victim)
                made.killed.add(victim)
            if isinstance(event.fact, RecordedReply) and not event.fact.accepted:
                made.refused.append(event.fact.reason)
            made.estimated_last = made.estimated_last or is_estimate(event, assists=6)
        made.ended = live.phase
        # The dialogue asks on only once it has the estimate of its present assists, so every later assist proves the
        # restarted node. This follower may meet that node later than the dialogue does, but the last word is latched.
        while not made.estimated_last:
            made.estimated_last = is_estimate(live.follower.events.get(timeout=60), assists=6)
        made.hanging = live.processes.stop(patience=20)
    made.replayed = tool("mbd_study", "replay", str(options.bag), "--check")
    return made


def test_a_mapping_node_killed_and_restarted_amid_the_assists_loses_nothing(disturbed: Disturbed):
    assert "mapping" in disturbed.killed
    assert disturbed.estimated_last
    assert disturbed.replayed.returncode == 0, disturbed.replayed.stdout + disturbed.replayed.stderr


def test_every_node_of_the_method_and_the_recorder_can_be_killed_once_and_the_session_still_ends_well(
    disturbed: Disturbed,
):
    assert disturbed.killed == {*VICTIMS.values(), "mapping"}
    assert disturbed.ended is Phase.DONE
    assert disturbed.hanging == []
    assert disturbed.replayed.returncode == 0, disturbed.replayed.stdout + disturbed.replayed.stderr


def test_wrong_wizard_events_are_refused_with_a_reason_and_change_nothing(disturbed: Disturbed):
    assert len(disturbed.refused) >= 4, disturbed.refused
    assert any("teapot" in text and "t1" in text for text in disturbed.refused), disturbed.refused
    assert disturbed.ended is Phase.DONE
    assert disturbed.replayed.returncode == 0, disturbed.replayed.stdout + disturbed.replayed.stderr


def test_a_wrong_assist_is_asked_about_before_the_robot_goes_on_alone_and_corrected(tmp_path: Path):
    """Every step is answered, one wrongly; asked "is that so?" the teacher says no and gives the right one."""
    options = SessionOptions(
        "slip", tmp_path / "slip", task="sorting", seed=1, strategy="evidence", threshold=1.0, speed=0.0, wrong_step=0
    )
    asked, states = [], []
    with LiveSession(options) as live:
        for event in live.events(timeout=400):
            if event is None:
                continue
            if isinstance(event.fact, Prompt) and event.fact.kind is PromptKind.CONFIRM_ASSIST:
                asked.append(event.fact)
            if isinstance(event.fact, MappingEstimate):
                states.append(event.fact)
        assert live.phase is Phase.DONE
        live.processes.stop(patience=20)
    _, session = open_session(options.bag)
    wrong = next(a for r in session.assists for a in r.value if a.step_index == 0)
    assert [(p.source_id, p.target_ids) for p in asked] == [(wrong.source_id, (wrong.target_id,))]
    assert [(d.source_id, d.target_id) for d in session.denials[-1].value] == [(wrong.source_id, wrong.target_id)]
    answers = answers_of(session)
    assert answers is not None and not answers.is_right(wrong.source_id, wrong.target_id)
    assert answers.maps_right(states[-1].executed, session.tasks[-1].value.used_objects)
    replayed = tool("mbd_study", "replay", str(options.bag), "--check")
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


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
