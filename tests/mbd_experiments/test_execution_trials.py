"""Execution in the simulated cell, from perceived objects and a demonstration read off the tool's path."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.outcome import outcomes
from mbd_execution.execution import assisted_again, begin, progress
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_experiments.execution_trials.simulated_session import Shown, execute, object_states, right_mapping, show
from mbd_experiments.execution_trials.trials import NotShown, Trial, run_trials
from mbd_experiments.perceiving import cell_perception
from mbd_model.execution_progress import Status
from mbd_model.objects import Role
from mbd_model.parallel.local_processes import LocalProcesses

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


def test_the_objects_end_where_the_demonstration_put_those_they_stand_for_and_a_bad_trial_spoils_no_other():
    which = [("stacking", 2), ("juggling", 2), ("sorting", 2)]
    stacked, missing, sorted_ = [trial for trial, _ in run_trials(which, LocalProcesses(2), CELL, KNOWLEDGE)]
    assert isinstance(stacked, Trial) and stacked.success, stacked
    assert isinstance(sorted_, Trial) and sorted_.success, sorted_
    assert [(t.task, t.seed) for t in (stacked, missing, sorted_)] == which
    assert isinstance(missing, NotShown) and "juggling" in missing.reason


def test_a_packed_lunch_is_packed_as_the_demonstrated_one(packed: Shown):
    names = packed.names
    mapping = {names[Role.SOURCE][s]: names[Role.TARGET][t] for s, t in right_mapping(packed).items()}
    places = outcomes(packed.cell.scenes.steps, packed.left, object_states(packed.cell), mapping)
    assert [p.success for p in places] == [True, True, True], places


def test_a_wrong_object_does_not_count_as_success(packed: Shown):
    """The measure can fail: with two objects exchanged the lunch is not the demonstrated one."""
    wrong = {"milk": "snack_box", "lunch_box": "juice", "pear": "apple", "chips": "crackers"}
    places = outcomes(packed.cell.scenes.steps, packed.left, object_states(packed.cell), wrong)
    assert not any(p.success for p in places)


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
    places = outcomes(shown.cell.scenes.steps, shown.left, object_states(shown.cell), mapping)
    assert [p.success for p in places] == [False, True, True]
