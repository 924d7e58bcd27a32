"""Execution in the simulated cell, from perceived objects and a demonstration read off the tool's path."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.storage.bag import Bag
from mbd_cell.adversary import TableDisturbance
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.outcome import object_states, outcomes
from mbd_cell.physics.displacing import put
from mbd_execution.choosing import next_motion
from mbd_execution.execution import assisted_again, begin, progress
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_experiments.execution_trials.referee import Referee
from mbd_experiments.execution_trials.result import TrialCase
from mbd_experiments.execution_trials.simulated_session import Shown, execute, right_mapping, show
from mbd_experiments.execution_trials.trials import TrialFolder, run_trials
from mbd_experiments.perceiving import cell_perception
from mbd_model.execution_progress import Status
from mbd_model.objects import Role
from mbd_model.parallel.local_processes import LocalProcesses
from mbd_model.session import Phase

pytestmark = pytest.mark.system

SRC = Path(__file__).resolve().parents[2] / "ros2_ws" / "src"
CELL, KNOWLEDGE = SRC / "mbd_cell" / "config", SRC / "mbd_perception" / "config" / "knowledge.yaml"
SEEN = cell_perception(CELL, KNOWLEDGE)


def scenes(task: str):
    return load_scenes(CELL / f"{task}.yaml")


@pytest.fixture(scope="module")
def packed() -> Shown:
    """A packed lunch: the cell after the robot executed the task with the right mapping."""
    shown = show(scenes("lunch_packing"), 2, SEEN)
    execute(begin(plan(shown.task, shown.target, right_mapping(shown)), HandConfig()), shown.cell)
    return shown


def test_complete_sessions_are_right_leave_what_failed_behind_and_are_not_done_twice(tmp_path: Path):
    """From what is seen to the last object, the mapping inferred: one trial goes well, one cannot, one is disturbed."""
    which = [
        TrialCase("lunch_packing", 2),
        TrialCase("juggling", 2),
        TrialCase("lunch_packing", 4, disturbances=(TableDisturbance.LIE, TableDisturbance.ADD)),
    ]
    folder = TrialFolder(tmp_path, CELL, KNOWLEDGE, keep_all=True)
    packed, missing, disturbed = first = list(run_trials(which, folder, LocalProcesses(2)))
    assert packed.right and packed.places_right == packed.places == 3, packed
    assert not missing.right and "juggling" in missing.why
    assert "spare was added" in disturbed.disturbed
    assert session_from_bag(Bag(folder.evidence(which[0]) / "bag")).states[-1].value.phase is Phase.DONE
    assert "juggling" in (folder.evidence(which[1]) / "why.txt").read_text(encoding="utf-8")
    assert list(run_trials(which, folder, LocalProcesses(1))) == first


def test_a_packed_lunch_is_packed_as_the_demonstrated_one(packed: Shown):
    names = packed.names
    mapping = {names[Role.SOURCE][s]: names[Role.TARGET][t] for s, t in right_mapping(packed).items()}
    places = outcomes(packed.cell.scenes.steps, packed.left, object_states(packed.cell.simulation), mapping)
    assert [p.success for p in places] == [True, True, True], places


def test_a_wrong_object_does_not_count_as_success(packed: Shown):
    """The measure can fail: with two objects exchanged the lunch is not the demonstrated one."""
    wrong = {"milk": "snack_box", "lunch_box": "juice", "pear": "apple", "chips": "crackers"}
    places = outcomes(packed.cell.scenes.steps, packed.left, object_states(packed.cell.simulation), wrong)
    assert not any(p.success for p in places)


def test_of_two_that_were_exchanged_the_hand_may_touch_the_one_that_stands_where_it_goes():
    shown = show(scenes("lunch_packing"), 2, SEEN)
    work, _ = next_motion(begin(plan(shown.task, shown.target, right_mapping(shown)), HandConfig()), True)
    assert work.course is not None
    picked = shown.names[Role.TARGET][work.course.transfer.held]
    receiver = shown.names[Role.TARGET][work.course.transfer.receiver]
    physics = shown.cell.simulation
    other = next(name for name in physics.objects if name not in (picked, receiver))
    referee = Referee(shown.cell)
    referee.handles(work)
    assert referee.handled == {picked, receiver}
    here, there = physics.object_pose(picked), physics.object_pose(other)
    put(physics, picked, there)
    put(physics, other, here)
    referee.handles(work)
    assert referee.handled == {other, receiver}


def test_an_object_that_was_moved_away_is_missed_twice_asked_about_and_left_out_while_the_rest_is_done():
    shown = show(scenes("lunch_packing"), 2, SEEN)
    physics = shown.cell.simulation
    address = physics.model.joint("juice").qposadr[0]
    # Far to the side, where nobody looked for it.
    physics.data.qpos[address : address + 2] = (0.75, -0.5)
    mujoco.mj_forward(physics.model, physics.data)
    work = execute(begin(plan(shown.task, shown.target, right_mapping(shown)), HandConfig()), shown.cell)
    reported = progress(work)
    assert reported.status is Status.FAILED and reported.step_index == 0
    assert "closed on nothing" in reported.text
    assert shown.cell.holding is None
    work = execute(assisted_again(work, work.plan, frozenset()), shown.cell)
    assert work.finished
    names = shown.names
    mapping = {names[Role.SOURCE][s]: names[Role.TARGET][t] for s, t in right_mapping(shown).items()}
    places = outcomes(shown.cell.scenes.steps, shown.left, object_states(shown.cell.simulation), mapping)
    assert [p.success for p in places] == [False, True, True]
