"""Complete sessions as separate processes in the simulated cell, recorded and replayed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from pathlib import Path

import pytest
from mbd_bag.session.command_line import open_session
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.live_session import LiveSession, install_prefixes
from mbd_model.estimate import MappingEstimate
from mbd_model.session import Phase, Prompt, PromptKind
from mbd_study.tables.correctness import answers_of

pytestmark = pytest.mark.timeout(600)


def tool(package: str, executable: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run one of our command-line tools."""
    path = install_prefixes([package])[package] / "lib" / package / executable
    return subprocess.run([str(path), *words], capture_output=True, text=True, check=False, timeout=300)


def test_the_demo_finds_the_right_mapping_and_its_bag_replays_to_equal_estimates(tmp_path: Path):
    out = tmp_path / "session"
    done = tool("mbd_bringup", "demo", "--task=lunch_packing", "--seed=2", "--out", str(out))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "agrees" in done.stdout
    table = tool("mbd_study", "table", str(out / "bag"))
    last = [line for line in table.stdout.splitlines() if re.search(r"\b(right|wrong)\b", line)][-1]
    assert "right" in last, table.stdout
    assert (out / "mapping.png").stat().st_size > 10_000
    assert (out / "bag" / "metadata.yaml").exists()


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
