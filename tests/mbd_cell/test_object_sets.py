"""Sets of objects drawn anew keep the sense of their task, whatever the seed."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_cell.layout.object_sets import drawn_scenes
from mbd_cell.layout.placement import layout
from mbd_cell.layout.scenes import ObjectSpec, Shape, TaskScenes
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_perception.features.knowledge import load_knowledge
from shipped_scenes import TASKS, scenes_of

SRC = Path(__file__).resolve().parents[2] / "ros2_ws" / "src"
SHIPPED = {task: scenes_of(task) for task in TASKS}
KNOWLEDGE = load_knowledge(SRC / "mbd_perception" / "config" / "knowledge.yaml")
CLASS = {Shape.CUP: "cup", Shape.BOWL: "bowl"}
seeds, tasks = st.integers(0, 2**31 - 1), st.sampled_from(TASKS)


def of(scenes: TaskScenes, role: Role) -> dict[str, ObjectSpec]:
    return {o.name: o for o in scenes.objects(role)}


def apart(one: float, other: float) -> float:
    """Degrees between two hues."""
    return abs((one - other + 180.0) % 360.0 - 180.0)


@given(tasks, seeds)
@settings(max_examples=60, deadline=None)
def test_a_drawn_set_is_a_function_of_its_seed_with_the_names_and_the_solution_of_the_task(task: str, seed: int):
    drawn = drawn_scenes(SHIPPED[task], seed)
    assert drawn == drawn_scenes(SHIPPED[task], seed)
    for role in Role:
        assert [*of(drawn, role)] == [*of(SHIPPED[task], role)]
        assert all(o.size != of(SHIPPED[task], role)[o.name].size for o in drawn.objects(role))
    assert drawn.solution == SHIPPED[task].solution
    assert len(layout(drawn, Role.TARGET, seed)) == len(drawn.target)


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_a_drawn_tower_still_falls_in_size_from_cup_to_cup(seed: int):
    drawn = drawn_scenes(SHIPPED["stacking"], seed)
    for cups in (drawn.source, drawn.target):
        rims = [cup.size[0] for cup in cups]
        assert all(0.8 < smaller / larger < 0.89 for larger, smaller in itertools.pairwise(rims)), rims


@given(st.sampled_from(("sorting", "assembly")), seeds)
@settings(max_examples=60, deadline=None)
def test_where_hue_decides_the_right_target_is_nearer_in_hue_than_any_of_another_colour(task: str, seed: int):
    drawn = drawn_scenes(SHIPPED[task], seed)
    source, target = of(drawn, Role.SOURCE), of(drawn, Role.TARGET)
    for name, right in drawn.solution.items():
        wrong = [t for s, ts in drawn.solution.items() for t in ts if t not in right]
        near = max(apart(source[name].hue, target[t].hue) for t in right)
        assert near < min(apart(source[name].hue, target[t].hue) for t in wrong), name


@given(st.sampled_from(("sorting", "dish_sorting")), seeds)
@settings(max_examples=60, deadline=None)
def test_a_small_cup_goes_into_the_large_one(task: str, seed: int):
    for cups in (drawn_scenes(SHIPPED[task], seed).source, drawn_scenes(SHIPPED[task], seed).target):
        rims = sorted(o.size[0] for o in cups if o.shape is Shape.CUP)
        assert not rims or rims[0] < 0.95 * rims[-1] - 0.01


@given(tasks, seeds)
@settings(max_examples=60, deadline=None)
def test_a_drawn_object_is_known_as_what_it_was_drawn_as(task: str, seed: int):
    for role in Role:
        shipped = of(SHIPPED[task], role)
        for thing in drawn_scenes(SHIPPED[task], seed).objects(role):
            as_drawn = KNOWLEDGE.match(thing.size, thing.hue).name
            before = KNOWLEDGE.match(shipped[thing.name].size, shipped[thing.name].hue).name
            assert as_drawn == (CLASS[thing.shape] if thing.shape is not shipped[thing.name].shape else before)


def test_a_task_without_rules_is_refused_by_name():
    with pytest.raises(MbdError, match="juggling"):
        drawn_scenes(replace(SHIPPED["sorting"], task="juggling"), 1)
