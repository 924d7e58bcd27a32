"""Faults are drawn alike for every node, and what cannot be used is refused; the machine's own network is never cut."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
import rclpy
from hypothesis import given
from hypothesis import strategies as st
from mbd_bringup.chaos.faults import OF_ONE_NODE, FaultKind, PlannedFault, draw_sessions, marks
from mbd_bringup.chaos.processes_at_fault import in_own_network, set_network, strike
from mbd_bringup.nodes import NodeSpec
from mbd_bringup.processes import NodeProcess
from mbd_bringup.ros.chaos.person_beside import PATIENCE, PersonBeside
from mbd_bringup.ros.chaos.trials import main
from mbd_model.errors import MbdError
from mbd_model.ros.qos import EVENTS
from mbd_model.ros.stop_line import StopLine
from mbd_model.stop import StopCause
from mbd_msgs.msg import WizardCommand
from rclpy.executors import SingleThreadedExecutor

NODES = ("recorder", "spool", "mapping", "cell", "wizard", "console")


@given(
    sessions=st.integers(1, 8),
    each=st.integers(1, 17),
    seed=st.integers(0, 9),
    kinds=st.sets(st.sampled_from(FaultKind), min_size=1),
)
def test_every_node_is_a_victim_as_often_as_any_other_and_of_three_faults_two_are_kills(sessions, each, seed, kinds):
    drawn = draw_sessions(sessions, each, tuple(sorted(kinds)), NODES, seed=seed, execute=False)
    assert drawn == draw_sessions(sessions, each, tuple(sorted(kinds)), NODES, seed=seed, execute=False)
    faults = [f for session in drawn for f in session]
    assert len(faults) == sessions * each
    assert all(len({f.mark for f in session}) == each for session in drawn)
    assert {f.mark for f in faults} <= set(marks(execute=False))
    for kind in kinds & set(OF_ONE_NODE):
        struck = Counter(f.victim for f in faults if f.kind is kind)
        assert max(struck.values(), default=0) - min((struck[n] for n in NODES), default=0) <= 1
    if FaultKind.KILL in kinds and len(kinds) > 1:
        assert abs(sum(f.kind is FaultKind.KILL for f in faults) - 2 * len(faults) / 3) <= 2


def test_the_person_beside_lets_the_robot_go_on_a_while_after_each_stop_and_says_it_again_until_it_does(ros_domain):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("tested", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        line, person = StopLine(node), PersonBeside(node)
        said: list[WizardCommand] = []
        node.create_subscription(WizardCommand, "wizard/command", said.append, EVENTS)

        def look(now: float) -> tuple[bool, int]:
            first = person.let_go_on(now)
            for _ in range(10):
                executor.spin_once(timeout_sec=0.05)
            return first, len(said)

        def until_it_is(held: bool) -> None:
            while person.stands is not held:
                executor.spin_once(timeout_sec=0.05)

        assert look(0.0) == (False, 0)
        for number, at in enumerate((10.0, 100.0)):
            line.stop(StopCause.PROTECTIVE_STOP, "the arm left its trajectory")
            until_it_is(True)
            assert look(at) == (False, 2 * number)
            assert look(at + PATIENCE) == (True, 2 * number + 1)
            assert look(at + 1.5 * PATIENCE) == (False, 2 * number + 1)
            assert look(at + 2.0 * PATIENCE) == (False, 2 * number + 2)
            line.release()
            until_it_is(False)
            assert look(at + 50.0) == (False, 2 * number + 2)
        assert {word.command for word in said} == {WizardCommand.RESUME}
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()


@pytest.fixture
def sleeper(tmp_path: Path):
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"], start_new_session=True)
    yield NodeProcess(NodeSpec("pkg", "sleeper"), (), process, tmp_path / "log")
    process.kill()
    process.wait()


def fault(kind: FaultKind, victim: str = "sleeper") -> PlannedFault:
    return PlannedFault("phase ASSIST", kind, victim, 0.0, 1.0)


def state_of(node: NodeProcess) -> str:
    return Path(f"/proc/{node.process.pid}/stat").read_text().rpartition(")")[2].split()[0]


def test_a_stopped_node_goes_on_and_a_limit_of_its_files_is_lifted(sleeper: NodeProcess):
    end = strike(fault(FaultKind.STOP), [sleeper], lambda: None)
    os.waitid(os.P_PID, sleeper.process.pid, os.WSTOPPED | os.WNOWAIT)
    assert state_of(sleeper) == "T"
    end()
    os.waitid(os.P_PID, sleeper.process.pid, os.WCONTINUED | os.WNOWAIT)
    assert state_of(sleeper) != "T"
    before = resource.prlimit(sleeper.process.pid, resource.RLIMIT_FSIZE)
    end = strike(fault(FaultKind.DISK, ""), [sleeper], lambda: None)
    assert resource.prlimit(sleeper.process.pid, resource.RLIMIT_FSIZE)[0] == 0
    end()
    assert resource.prlimit(sleeper.process.pid, resource.RLIMIT_FSIZE) == before
    both = [strike(fault(FaultKind.DISK, ""), [sleeper], lambda: None) for _ in range(2)]
    for end_one in both:
        assert end_one is not None
        end_one()
    assert resource.prlimit(sleeper.process.pid, resource.RLIMIT_FSIZE) == before


def test_a_fault_of_a_node_that_is_gone_does_not_strike(sleeper: NodeProcess):
    strike(fault(FaultKind.KILL), [sleeper], lambda: None)
    assert sleeper.process.wait() == -9
    assert strike(fault(FaultKind.KILL), [sleeper], lambda: None) is None
    assert strike(fault(FaultKind.KILL, "nobody"), [sleeper], lambda: None) is None


@pytest.mark.parametrize("claimed", ["", str(Path("/proc/self/ns/net").readlink())])
def test_the_machine_s_own_network_is_never_cut(monkeypatch: pytest.MonkeyPatch, claimed: str):
    monkeypatch.setenv("MBD_CHAOS_FORMER_NETWORK", claimed)
    assert not in_own_network()
    with pytest.raises(MbdError, match="not cut"):
        set_network(up=False)


@pytest.mark.parametrize(
    ("words", "why"), [(["--each", "99"], "expected 1 to 17"), (["--each", "0"], "expected 1 or more")]
)
def test_more_faults_than_a_session_has_room_for_are_refused(tmp_path: Path, words, why, capsys):
    with pytest.raises(SystemExit) as ended:
        main([*words, "--faults", "kill", "--out", str(tmp_path)])
    assert ended.value.code == 2
    assert why in capsys.readouterr().err


def test_sessions_that_are_there_are_not_overwritten(tmp_path: Path, capsys):
    (tmp_path / "session_0").mkdir()
    with pytest.raises(SystemExit) as ended:
        main(["--faults", "kill", "--out", str(tmp_path)])
    assert ended.value.code == 2
    assert "no session is overwritten" in capsys.readouterr().err
