"""Complete simulated sessions: from rendered pictures to bags, resumed when they were cut off."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from mbd_experiments.simulated_participants.error_model import Intention, Slip, intentions
from mbd_experiments.simulated_participants.study import Finished, is_finished, remaining, run_study
from mbd_experiments.user_study.cases import case_of_session
from mbd_experiments.user_study.consistency import assists_consistent, demonstration_consistent, recorded_pairs
from mbd_model.parallel.local_processes import HERE
from mbd_model.session import Phase
from mbd_study.recompute.reevaluation import reevaluate

pytestmark = pytest.mark.system

SRC = Path(__file__).resolve().parents[2] / "ros2_ws" / "src"
SCENES, KNOWLEDGE = SRC / "mbd_cell" / "config", SRC / "mbd_perception" / "config" / "knowledge.yaml"
# A study of one participant and task, in which he states one answer twice and all else is as it should be.
STUDY = ("--participants", "1", "--tasks", "lunch_packing", "--seed", "3", "--jobs", "1")
(FAULTLESS,) = intentions(1, 3, ("lunch_packing",))
MIXED_UP = Intention("p2", "sorting", 4, (Slip.MOVED_STACK, Slip.WRONG_ORDER))


def run(intention: Intention, out: Path) -> tuple[Finished, RecordedSession]:
    ((_, finished),) = run_study([intention], out, executor=HERE, scenes=SCENES, knowledge=KNOWLEDGE)
    assert isinstance(finished, Finished), finished
    return finished, session_from_bag(Bag(finished.bag))


def cut_off(bag: Path) -> Path:
    """What a killed worker leaves of a session."""
    bag.mkdir()
    (bag / f"{bag.name}_0.mcap").write_bytes(b"cut")
    return bag


@pytest.fixture(scope="module")
def lunch(tmp_path_factory: pytest.TempPathFactory) -> tuple[Finished, RecordedSession]:
    """A session done again after its first worker was killed."""
    folder = tmp_path_factory.mktemp("lunch")
    cut_off(folder / FAULTLESS.name)
    return run(FAULTLESS, folder)


@pytest.fixture(scope="module")
def mixed_up(tmp_path_factory: pytest.TempPathFactory) -> tuple[Finished, RecordedSession]:
    return run(MIXED_UP, tmp_path_factory.mktemp("mixed"))


def test_a_session_goes_through_every_phase(lunch: tuple[Finished, RecordedSession]):
    finished, session = lunch
    phases = [s.value.phase for s in session.states]
    assert list(dict.fromkeys(phases)) == [Phase(k) for k in range(1, 8)]
    assert finished.simulated > 30.0
    assert FAULTLESS.slips == (Slip.REPEATED,)
    assert finished.troubles == ()


def test_its_bag_is_like_a_recorded_one(lunch: tuple[Finished, RecordedSession]):
    finished, session = lunch
    bag = Bag(finished.bag)
    assert bag.problems == ()
    counts = {t.name: t.count for t in bag.topics}
    assert counts["/camera/color/image_raw/compressed"] == counts["/camera/depth/image_raw/compressedDepth"] == 6
    assert counts["/j2n6s300_driver/out/tool_pose"] > 500
    assert counts["/wizard/gripper"] == len(session.tasks[0].value.steps) == 6
    assert bag.facts["study.origin"] == "simulated"
    times = [message.log_time for message in bag.messages()]
    assert times == sorted(times)


def test_its_estimates_are_computed_again_from_its_bag(
    lunch: tuple[Finished, RecordedSession], mixed_up: tuple[Finished, RecordedSession]
):
    for _, session in (lunch, mixed_up):
        comparisons = reevaluate(session)
        assert all(c.agrees for c in comparisons)
        counts = [c.recorded.value.num_assists for c in comparisons]
        # One assist after another; one that was asked about and taken back is one less.
        assert counts[0] == 0
        assert all(abs(after - before) <= 1 for before, after in itertools.pairwise(counts))


def test_without_slips_everything_is_as_asked_and_right(lunch: tuple[Finished, RecordedSession]):
    case = case_of_session(lunch[1])
    assert demonstration_consistent(case)
    assert assists_consistent(case)
    assert case.solved_by(lunch[1].estimates[-1][0].value.mapping.as_dict)


def test_an_answer_given_twice_is_refused_and_then_given_rightly(lunch: tuple[Finished, RecordedSession]):
    refused = [r.value.reason for r in lunch[1].replies if not r.value.accepted]
    assert len(refused) == 1
    assert refused[0].startswith("repeated")


def test_a_moved_stack_and_a_wrong_order_show_in_what_was_recorded(mixed_up: tuple[Finished, RecordedSession]):
    case = case_of_session(mixed_up[1])
    assert not demonstration_consistent(case)
    assert not assists_consistent(case)
    assert len(case.task.steps) == 8
    # What was moved is followed: what is placed onto it later still names it.
    pairs = recorded_pairs(case)
    (moved,) = [picked for picked, onto in pairs if picked == onto]
    assert [onto for picked, onto in pairs if picked != moved].count(moved) == 1


def test_a_study_goes_on_where_it_was_cut_off(lunch: tuple[Finished, RecordedSession], tmp_path: Path):
    study = intentions(2, 1, ("lunch_packing",))
    assert remaining(study, tmp_path) == list(study)
    cut = cut_off(tmp_path / study[0].name)
    assert remaining(study, tmp_path) == list(study)
    assert not cut.exists()
    assert remaining([FAULTLESS, study[1]], lunch[0].bag.parent) == [study[1]]


def test_a_study_of_another_seed_or_other_files_are_not_touched(
    lunch: tuple[Finished, RecordedSession], tmp_path: Path
):
    other = Intention(FAULTLESS.participant, FAULTLESS.task, FAULTLESS.seed + 1, ())
    with pytest.raises(BagError, match="another seed"):
        remaining([other], lunch[0].bag.parent)
    (tmp_path / other.name).mkdir()
    (tmp_path / other.name / "thesis.txt").write_text("mine")
    with pytest.raises(BagError, match="no bag"):
        remaining([other], tmp_path)
    assert (tmp_path / other.name / "thesis.txt").read_text() == "mine"


def test_killed_in_the_middle_the_command_does_it_again_and_the_same_seed_gives_the_same_session(
    lunch: tuple[Finished, RecordedSession], tmp_path: Path
):
    code = "import sys; from mbd_experiments.simulated_participants.study import main; main()"
    command = [sys.executable, "-c", code, str(tmp_path), *STUDY]
    bag = tmp_path / FAULTLESS.name
    process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL)
    end = time.monotonic() + 120.0
    while not bag.exists():
        assert process.poll() is None and time.monotonic() < end
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert not is_finished(bag)
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 sessions simulated" in done.stdout
    assert session_from_bag(Bag(bag)) == lunch[1]
    before = {p.name: (p.stat().st_mtime_ns, p.stat().st_size) for p in bag.iterdir()}
    again = subprocess.run(command, capture_output=True, text=True, check=False)
    assert again.returncode == 0, again.stdout + again.stderr
    assert "0 sessions simulated" in again.stdout
    assert {p.name: (p.stat().st_mtime_ns, p.stat().st_size) for p in bag.iterdir()} == before
