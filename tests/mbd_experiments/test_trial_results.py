"""What trials are counted by: intervals, halves, verdicts, teacher's errors, and the files a run goes on from."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_cell.adversary import TableDisturbance
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.layout.scenes import ObjectSpec
from mbd_cell.outcome import ObjectState
from mbd_cell.physics.grasp import Grasp
from mbd_cell.physics.simulation import Pose
from mbd_experiments.execution_trials.judging import judge, last_places, right_mappings
from mbd_experiments.execution_trials.result import (
    TASKS,
    TrialCase,
    TrialHalf,
    TrialResult,
    cases,
    read_result,
    write_result,
)
from mbd_experiments.execution_trials.summary import RightShare, summaries
from mbd_experiments.execution_trials.teacher_errors import ERRORS, drawn_errors
from mbd_experiments.execution_trials.trials import TrialFolder, finished
from mbd_experiments.simulated_participants.error_model import TABLE5, Slip
from mbd_model.errors import MbdError

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_cell" / "config"
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


@given(st.integers(1, 300), st.data())
@settings(max_examples=50, deadline=None)
def test_the_interval_holds_the_share_and_narrows_with_more_trials(of: int, data: st.DataObject):
    hits = data.draw(st.integers(0, of))
    low, high = RightShare(hits, of).interval
    wider = RightShare(4 * hits, 4 * of).interval
    assert 0.0 <= low <= hits / of <= high <= 1.0 and wider[1] - wider[0] < high - low


def test_the_interval_is_wilsons():
    """45 of 50, by the formula: 0.786 to 0.957."""
    assert RightShare(45, 50).interval == pytest.approx((0.7864, 0.9565), abs=1e-4)


def test_the_adversary_takes_turns_so_that_each_half_gets_every_disturbance_alike():
    which = cases(("sorting",), range(24), tuple(TableDisturbance), True, TrialCase("", 0))
    for half in TrialHalf:
        drawn = [c.disturbances for c in which if TrialHalf.of(c.seed) is half]
        assert all(drawn.count((d,)) == 2 for d in TableDisturbance)
    assert all(
        c.disturbances == tuple(TableDisturbance) for c in cases(TASKS, (1,), tuple(TableDisturbance), False, which[0])
    )


@given(st.sampled_from(TASKS), st.integers(0, 10_000), st.sets(st.sampled_from(list(Slip))))
@settings(max_examples=80, deadline=None)
def test_no_teacher_makes_an_error_that_is_not_switched_on(task: str, seed: int, on: set[Slip]):
    assert set(drawn_errors(task, seed, tuple(on)).slips) <= on


@pytest.mark.parametrize("task", TABLE5)
def test_teachers_err_at_the_rates_of_table_5(task: str):
    drawn = [set(drawn_errors(task, seed, tuple(ERRORS.values())).slips) for seed in range(2000)]
    shown_wrong = {Slip.WRONG_OBJECT, Slip.MOVED_STACK, Slip.PUT_ASIDE}
    row = TABLE5[task]
    assert sum(not slips & shown_wrong for slips in drawn) / 2000 == pytest.approx(
        row.demonstrations / row.of, abs=0.04
    )
    assert sum(Slip.WRONG_ORDER not in slips for slips in drawn) / 2000 == pytest.approx(row.assists / row.of, abs=0.04)


def test_a_kept_result_is_read_as_it_was_and_one_under_other_conditions_is_refused(tmp_path: Path):
    case, folder = TrialCase("sorting", 3), TrialFolder(tmp_path, tmp_path, tmp_path)
    assert finished(case, folder) is None
    folder.result(case).parent.mkdir()
    result = TrialResult("sorting", 3, case.conditions, right=False, places=3, why="a bowl: it lies below")
    write_result(folder.result(case), result)
    assert finished(case, folder) == result == read_result(folder.result(case))
    others: list[dict[str, Any]] = [
        {"grasp": Grasp.FRICTION}, {"disturbances": (TableDisturbance.PUSH,)}, {"threshold": 0.3},
    ]  # fmt: skip
    for other in (replace(case, **changed) for changed in others):
        with pytest.raises(MbdError, match="give another"):
            finished(other, folder)
    folder.result(case).write_text("{", encoding="utf-8")
    with pytest.raises(MbdError, match="remove it"):
        finished(case, folder)


def test_every_trial_is_in_a_task_a_half_and_all_and_failures_lower_only_their_own_shares():
    results = [
        TrialResult(task, seed, "grasp weld", right=task != "sorting" or seed != 3, seconds=30.0)
        for task, seed in itertools.product(("sorting", "stacking"), (2, 3, 4, 5))
    ]
    rows = {s.name: s.right for s in summaries(results)}
    assert rows == {
        "sorting": RightShare(3, 4),
        "stacking": RightShare(4, 4),
        "half choose": RightShare(4, 4),
        "half report": RightShare(3, 4),
        "all": RightShare(7, 8),
    }


def stacked(things: tuple[ObjectSpec, ...]) -> dict[str, ObjectState]:
    """A tower of these in order, the first below."""
    states, height = {}, 0.0
    for thing in things:
        states[thing.name] = ObjectState(Pose((0.4, 0.0, height + thing.size[2] / 2), UPRIGHT), thing.size)
        height += thing.size[2]
    return states


def test_a_tower_built_of_the_right_cups_is_right_and_one_with_two_exchanged_is_not():
    scenes = load_scenes(CONFIG / "stacking.yaml")
    left, target = stacked(scenes.source), scenes.target
    assert judge(scenes, left, stacked(target)).right
    exchanged = judge(scenes, left, stacked((*target[:3], target[4], target[3])))
    assert not exchanged.right and "teal_cup" in exchanged.wrong


def test_any_of_the_right_mappings_counts_but_no_target_twice():
    scenes = load_scenes(CONFIG / "sorting.yaml")
    found = list(right_mappings(scenes))
    assert len(found) == 8
    assert all(len(set(mapping.values())) == 6 for mapping in found)


def test_where_an_object_was_put_aside_in_between_does_not_count():
    steps = load_scenes(CONFIG / "assembly.yaml").steps
    twice = (steps[2], steps[1], *steps[2:])
    aside = (replace(steps[1], picked=steps[2].picked), *steps[2:])
    assert 1 in last_places(twice)
    assert 0 not in last_places(aside) and len(last_places(aside)) == 3
