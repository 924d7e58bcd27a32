"""Simulated participants go wrong as often as Table 5 states, and from the seed alone."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_cell.layout.placement import MAX_REACH, RESERVED_GAP, layout
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.layout.scenes import TaskScenes
from mbd_experiments.simulated_participants.error_model import (
    DEMONSTRATION_SLIPS,
    TABLE5,
    Consistency,
    Intention,
    Slip,
    intentions,
    quotas,
)
from mbd_experiments.simulated_participants.script import TOWER_REACH, pairs_of, participant_script
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.task import StepKind

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_cell" / "config"
SCENES: dict[str, TaskScenes] = {task: load_scenes(CONFIG / f"{task}.yaml") for task in TABLE5}
SHOWN_WRONG = {slip for slips in DEMONSTRATION_SLIPS.values() for slip in slips}


@given(st.integers(0, 10_000))
def test_ten_participants_are_consistent_exactly_as_in_table_5(seed: int):
    study = intentions(10, seed)
    for task, row in TABLE5.items():
        slips = [set(i.slips) for i in study if i.task == task]
        shown = [not s & SHOWN_WRONG for s in slips]
        ordered = [Slip.WRONG_ORDER not in s for s in slips]
        counts = (sum(shown), sum(ordered), sum(a and b for a, b in zip(shown, ordered, strict=True)))
        assert counts == (row.demonstrations, row.assists, row.both)


@given(st.integers(1, 40), st.integers(0, 1000))
def test_a_study_is_a_function_of_its_seed_and_names_each_session_once(participants: int, seed: int):
    study = intentions(participants, seed)
    assert study == intentions(participants, seed)
    assert len({i.name for i in study}) == len(study) == 3 * participants
    assert len({i.seed for i in study}) == len(study)


def test_another_seed_is_another_study():
    assert intentions(10, 1) != intentions(10, 2)


@given(st.integers(0, 10), st.integers(0, 10), st.integers(0, 10), st.integers(1, 57))
def test_quotas_are_complete_and_within_one_of_their_share(a: int, b: int, c: int, total: int):
    both, demonstrations, assists = min(a, b, c), max(a, min(a, b, c)), max(b, min(a, b, c))
    row = Consistency(demonstrations, assists, both, of=demonstrations + assists - both + 1)
    counts = quotas(row.cells, total)
    assert sum(counts.values()) == total
    assert all(abs(counts[cell] - share * total) < 1.0 + 1e-6 for cell, share in row.cells.items())


@pytest.mark.parametrize(("participants", "tasks"), [(0, ("sorting",)), (3, ("assembly",))])
def test_a_study_that_cannot_be_is_refused(participants: int, tasks: tuple[str, ...]):
    with pytest.raises(MbdError):
        intentions(participants, 1, tasks)


@pytest.mark.parametrize("task", TABLE5)
def test_a_faultless_participant_shows_and_means_the_script(task: str):
    script = participant_script(SCENES[task], Intention("p1", task, 5, ()))
    assert script.scenes == SCENES[task]
    assert script.meant == tuple(name for pair in script.asked for name in pair)
    assert pairs_of(script.scenes.steps) == script.asked


@pytest.mark.parametrize("task", TABLE5)
@given(seed=st.integers(1, 10_000), data=st.data())
def test_whatever_goes_wrong_picks_and_places_alternate_and_every_step_has_a_meaning(
    task: str, seed: int, data: st.DataObject
):
    slip = data.draw(st.sampled_from(DEMONSTRATION_SLIPS[task]))
    script = participant_script(SCENES[task], Intention("p1", task, seed, (slip,)))
    steps = script.scenes.steps
    assert [s.kind for s in steps] == [StepKind.PICK, StepKind.PLACE] * (len(steps) // 2)
    assert all(steps[k].picked == steps[k + 1].picked for k in range(0, len(steps), 2))
    assert all(s.onto != s.picked for s in steps)
    assert len(script.meant) == len(steps)
    assert Counter(pairs_of(steps)) != Counter(script.asked)


@pytest.mark.parametrize("task", ["stacking", "sorting"])
@given(seed=st.integers(1, 10_000), laid_by=st.integers(1, 10_000))
def test_what_is_moved_first_goes_to_a_free_place_of_the_table_as_it_is_laid(task: str, seed: int, laid_by: int):
    """Whatever the participant's own seed is; and not so far out that the arm does not reach over a tower there."""
    scenes = SCENES[task]
    steps = participant_script(scenes, Intention("p1", task, seed, (Slip.MOVED_STACK,)), laid_by).scenes.steps
    moved, (x, y) = steps[1].picked, steps[1].position
    radius = {o.name: o.footprint_radius for o in scenes.source}
    for there in layout(scenes, Role.SOURCE, laid_by):
        apart = math.hypot(x - there.x, y - there.y) - radius[there.name] - radius[moved]
        assert there.name == moved or apart >= RESERVED_GAP
    assert math.hypot(x, y) <= (TOWER_REACH if task == "stacking" else MAX_REACH)


@pytest.mark.parametrize("task", ["stacking", "sorting"])
@given(seed=st.integers(1, 10_000))
def test_in_the_wrong_order_the_demonstration_stays_right_and_two_objects_are_mixed_up(task: str, seed: int):
    script = participant_script(SCENES[task], Intention("p1", task, seed, (Slip.WRONG_ORDER,)))
    asked = tuple(name for pair in script.asked for name in pair)
    assert script.scenes == SCENES[task]
    assert Counter(script.meant) == Counter(asked)
    picks = [(a, b) for a, b in zip(script.meant[0::2], asked[0::2], strict=True) if a != b]
    assert len(picks) == 2


@pytest.mark.parametrize("task", TABLE5)
@given(seed=st.integers(1, 10_000))
def test_a_participant_prefers_some_right_target_of_each_object(task: str, seed: int):
    script = participant_script(SCENES[task], Intention("p1", task, seed, ()))
    for name, right in SCENES[task].solution.items():
        assert sorted(script.preference[name]) == sorted(right)
