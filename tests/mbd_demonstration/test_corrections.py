"""What the teacher corrects, the task keeps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.revision.corrections import carry_of, deleted, joined_steps, moved, split, with_object
from mbd_demonstration.revision.resuming import resume, shown_again_from
from mbd_demonstration.segmentation import segment
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_moves, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene
from mbd_model.task import StepKind, Task

SEEDS = st.integers(0, 2**32)


def shown(seed: int, moves: int = 3) -> tuple[Demonstration, ToolTrajectory, Task]:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 5)
    made = demonstrate(scene, random_moves(rng, scene, moves), Sensing(), rng)
    path = ToolTrajectory.from_samples(made.stamps, made.positions, made.quaternions)
    return made, path, segment(path, made.events, scene, stamp=1.0)


def names(task: Task) -> list[tuple[StepKind, str]]:
    return [(s.kind, s.primary_object) for s in task.steps]


def assert_whole(task: Task) -> None:
    """Steps are numbered, a PLACE follows each PICK, and a later recording can go on from it."""
    assert [s.index for s in task.steps] == list(range(len(task.steps)))
    kinds = [s.kind for s in task.steps]
    assert kinds == [StepKind.PICK, StepKind.PLACE] * (len(kinds) // 2)
    assert resume(task).awaited == ""


@given(seed=SEEDS, index=st.integers(0, 4))
def test_a_deleted_step_takes_the_other_half_of_its_carry_along(seed: int, index: int):
    _, _, task = shown(seed)
    less = deleted(task, index, 2.0)
    first, last = carry_of(task, index)
    assert names(less) == [n for k, n in enumerate(names(task)) if k not in (first, last)]
    assert "deleted by the teacher" in less.problems[-1] and less.stamp == 2.0
    assert_whole(less)


@given(seed=SEEDS, index=st.integers(0, 5), to=st.integers(0, 6))
def test_moving_keeps_every_step_and_carries_together(seed: int, index: int, to: int):
    _, _, task = shown(seed)
    other = moved(task, index, to, 2.0)
    assert sorted(names(other)) == sorted(names(task))
    assert_whole(other)
    back = names(other)
    first, last = carry_of(task, index)
    pair = names(task)[first : last + 1]
    assert any(back[k : k + 2] == pair for k in range(0, 6, 2))


@given(seed=SEEDS, index=st.integers(0, 5))
def test_another_primary_object_is_kept_without_doubt_and_told(seed: int, index: int):
    _, _, task = shown(seed)
    other = next(i for i in task.source.ids if i != task.steps[index].primary_object)
    changed = with_object(task, index, other, 2.0)
    step = changed.steps[index]
    assert (step.primary_object, step.runner_up, step.doubt) == (other, task.steps[index].primary_object, 0.0)
    assert f"to '{other}'" in changed.problems[-1]
    if step.kind is StepKind.PICK and task.steps[index + 1].primary_object == task.steps[index].primary_object:
        assert changed.steps[index + 1].primary_object == other  # on the table a PLACE names what is held


@given(seed=SEEDS, carry=st.integers(0, 2), share=st.floats(0.2, 0.8))
def test_joining_what_was_split_gives_the_task_back(seed: int, carry: int, share: float):
    _, path, task = shown(seed)
    place = 2 * carry + 1
    at = task.steps[place - 1].end * (1 - share) + task.steps[place].end * share
    two = split(task, place, path.pose_at(at), at, 2.0)
    assert len(two.steps) == 8 and two.steps[place].end == two.steps[place + 1].start == at
    assert_whole(two)
    again = joined_steps(two, place, 3.0)
    assert names(again) == names(task)
    assert [s.offset for s in again.steps] == [s.offset for s in task.steps]


@given(seed=SEEDS, first=st.integers(0, 2))
def test_steps_shown_again_replace_those_from_there_on(seed: int, first: int):
    made, _, task = shown(seed)
    last = Move(task.steps[-2].primary_object, place=(0.35, 0.5))  # nothing stands on what was moved last
    now = Scene(Role.SOURCE, made.after)
    again = demonstrate(now, (last,), Sensing(), np.random.default_rng(seed + 1), begin=1000.0)
    path = ToolTrajectory.from_samples(again.stamps, again.positions, again.quaternions)
    both = segment(path, again.events, made.scene, stamp=9.0, so_far=shown_again_from(task, 2 * first))
    assert names(both)[: 2 * first] == names(task)[: 2 * first]
    assert len(both.steps) == 2 * first + 2


@pytest.mark.parametrize(
    ("correct", "why"),
    [
        (lambda t, p: deleted(t, 6, 2.0), "there is no step 7: the task has 6"),
        (lambda t, p: moved(t, 0, 9, 2.0), "there is no step 10"),
        (lambda t, p: with_object(t, 0, "nobody", 2.0), "no object 'nobody'"),
        (lambda t, p: with_object(t, 0, t.steps[0].primary_object, 2.0), "already"),
        (lambda t, p: split(t, 0, p.pose_at(0.0), 3.0, 2.0), "only a PLACE"),
        (lambda t, p: split(t, 1, p.pose_at(0.0), 1e6, 2.0), "is not between"),
        (lambda t, p: joined_steps(t, 0, 2.0), "is not put down and taken again"),
    ],
)
def test_a_correction_that_cannot_be_is_refused_with_the_reason(correct, why):
    _, path, task = shown(0)
    with pytest.raises(MbdError, match=why):
        correct(task, path)
