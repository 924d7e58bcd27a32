"""What the robot is told it does, or it asks about it first."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_experiments.teacher_families.choosing import anyhow
from mbd_experiments.teacher_families.lesson import Lesson, told_in_order
from mbd_experiments.teacher_families.playing import finish
from mbd_experiments.teacher_families.scenes import plain
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import STRATEGIES, infer
from mbd_mapping.synthetic import random_problem
from mbd_model.assists import Assist, Denial
from mbd_model.estimate import QuestionKind
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

EVIDENCE = MappingConfig(strategy="evidence")


def alike(role: Role, prefix: str, count: int) -> Scene:
    """Cups that differ in nothing but their names, all in one place as far as relations go."""
    cup = SceneObject("cup", (0.5, 0.0, 0.05), (0.08, 0.08, 0.1), hue=10.0)
    return Scene(role, tuple(replace(cup, object_id=f"{prefix}{k}") for k in range(count)))


def task_over(scene: Scene) -> Task:
    """Every object picked up once."""
    return Task(scene, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(scene.ids)))


@pytest.mark.parametrize("strategy", sorted(STRATEGIES))
@pytest.mark.parametrize("told", list(itertools.permutations(range(4), 2)))
def test_identical_objects_are_told_apart_by_what_was_told(strategy: str, told: tuple[int, int]) -> None:
    """Four identical cups: c0 and c1 go where they were told to, wherever that is."""
    task, target = task_over(alike(Role.SOURCE, "c", 4)), alike(Role.TARGET, "d", 4)
    assists = [Assist(f"c{k}", f"d{place}", k) for k, place in enumerate(told)]
    found = infer(task, target, assists, MappingConfig(strategy=strategy))
    assert [found.mapping.as_dict[f"c{k}"] for k in range(2)] == [f"d{place}" for place in told]
    assert found.doubted is None


@pytest.mark.parametrize("strategy", sorted(STRATEGIES))
@pytest.mark.parametrize("count", [2, 3, 4])
def test_ties_are_never_sure(strategy: str, count: int) -> None:
    """Where nothing varies every mapping ties, and no strategy is surer than one in all of them."""
    task, target = task_over(alike(Role.SOURCE, "c", count)), alike(Role.TARGET, "d", count)
    found = infer(task, target, [], MappingConfig(strategy=strategy))
    possible = len(list(itertools.permutations(range(count))))
    assert found.ties == possible
    assert found.confidence <= 1.0 / possible + 1e-9
    assert not replace(found, threshold=0.0).confident


@pytest.mark.parametrize("confirmed", list(itertools.product([False, True], repeat=2)))
@pytest.mark.parametrize("later", [("c0", "d1"), ("c1", "d0")])
def test_the_later_of_two_contradicting_assists_holds_whatever_was_confirmed(
    later: tuple[str, str], confirmed: tuple[bool, bool]
) -> None:
    """Also over one the teacher said yes to before; and nothing comes out that is no number."""
    task, target = task_over(alike(Role.SOURCE, "c", 3)), alike(Role.TARGET, "d", 3)
    assists = [Assist("c0", "d0", 0, confirmed=confirmed[0]), Assist(*later, 1, confirmed=confirmed[1])]
    found = infer(task, target, assists, EVIDENCE)
    assert found.executed.as_dict[later[0]] == later[1]
    assert 0.0 <= found.best_guess.score <= 1.0
    assert 0.0 <= found.confidence <= 1.0


@pytest.mark.parametrize("size", [4, 5, 6])
def test_a_teacher_who_goes_by_nothing_measured_is_obeyed(size: int) -> None:
    """All told and what is asked about confirmed, every session ends as told, with few questions."""
    endings = []
    for seed in range(25):
        rng = np.random.default_rng([seed, size])
        scenes = plain(rng, (size,))
        columns, _ = anyhow(rng, scenes)
        lesson = Lesson(scenes.seen_source, scenes.seen_target, columns, None, told_in_order(rng, columns))
        endings.append(finish(lesson, EVIDENCE))
    assert all(ending.as_meant for ending in endings)
    assert sum(ending.questions for ending in endings) / len(endings) <= 0.5


def swapped_problem(seed: int) -> tuple[Task, Scene, list[Assist]]:
    """Six objects mapped by hue, two of six assists given for each other."""
    source, target = random_problem(np.random.default_rng(seed), 6)
    task = task_over(source)
    best = infer(task, target, [], EVIDENCE).mapping.as_dict
    told = [Assist(s, t, k) for k, (s, t) in enumerate(best.items())]
    told[1], told[4] = replace(told[1], target_id=told[4].target_id), replace(told[4], target_id=told[1].target_id)
    return task, target, told


def test_a_doubted_assist_is_asked_about_and_then_stands() -> None:
    """With a doubt the robot does not go on alone; confirmed, the assist is in the mapping and doubted no more."""
    doubted = 0
    for seed in range(12):
        task, target, told = swapped_problem(seed)
        found = infer(task, target, told, EVIDENCE)
        if found.doubted is None:
            continue
        doubted += 1
        assert not found.confident
        assert found.doubt >= EVIDENCE.doubt_at
        assert found.mapping == found.best_guess
        assert found.question_kind == QuestionKind.IS_THAT_SO
        assert (found.next_question, found.question_targets) == (found.doubted.source_id, (found.doubted.target_id,))
        assert found.obeying.as_dict == {a.source_id: a.target_id for a in told}
        sure = [replace(a, confirmed=a == found.doubted) for a in told]
        after = infer(task, target, sure, EVIDENCE)
        assert after.best_guess.as_dict[found.doubted.source_id] == found.doubted.target_id
        assert after.doubted is None or after.doubted.source_id != found.doubted.source_id
    assert doubted >= 6


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32), count=st.integers(1, 5))
def test_without_a_doubt_every_assist_in_force_is_held(seed: int, count: int) -> None:
    """The mapping carried out contradicts no assist unless the estimate says which one it asks about first."""
    rng = np.random.default_rng(seed)
    source, target = random_problem(rng, 5)
    told = [Assist(f"s{s}", f"t{t}") for s, t in zip(rng.permutation(5), rng.permutation(5), strict=True)][:count]
    found = infer(task_over(source), target, told, EVIDENCE)
    assert all(found.obeying.as_dict[a.source_id] == a.target_id for a in told)
    if found.doubted is None:
        assert all(found.mapping.as_dict[a.source_id] == a.target_id for a in told)
    assert found.obeying.score <= found.best_guess.score + 1e-9


def test_of_contradicting_assists_the_later_holds() -> None:
    """Told t1 and then t2 for s0, the obeying mapping takes t2, though t1 was confirmed before."""
    source, target = random_problem(np.random.default_rng(4), 5)
    first, second = Assist("s0", "t1"), Assist("s0", "t2")
    assert infer(task_over(source), target, [first, second], EVIDENCE).obeying.as_dict["s0"] == "t2"
    sure = replace(first, confirmed=True)
    assert infer(task_over(source), target, [sure, second], EVIDENCE).obeying.as_dict["s0"] == "t2"


def test_a_confirmed_assist_is_certain() -> None:
    """No alternative contradicts it, and it adds to the confidence."""
    source, target = random_problem(np.random.default_rng(5), 5)
    told = Assist("s0", "t3")
    plain_one = infer(task_over(source), target, [told], EVIDENCE)
    sure = infer(task_over(source), target, [replace(told, confirmed=True)], EVIDENCE)
    assert all(m.as_dict["s0"] == "t3" for m in (sure.best_guess, *sure.alternatives) if m.score > 0.0)
    assert sure.best_guess.score >= plain_one.obeying.score - 1e-9


def test_a_no_is_obeyed_unless_nothing_else_fits() -> None:
    """Denied, the likeliest target of an object is the likeliest no more; the paper's rule says it knows no "no"."""
    source, target = random_problem(np.random.default_rng(6), 5)
    before = infer(task_over(source), target, [], EVIDENCE).mapping.as_dict["s0"]
    after = infer(task_over(source), target, [], EVIDENCE, [Denial("s0", before)])
    assert after.mapping.as_dict["s0"] != before
    assert "denials" in infer(task_over(source), target, [], MappingConfig("mbd"), [Denial("s0", before)]).warnings[-1]


def test_a_hue_shift_without_a_mean_does_not_depend_on_the_order_of_the_assists() -> None:
    """Hue differences 0, 120 and 240 deg have no circular mean: there is no hue shift then, in any order."""

    def scene(role: Role, prefix: str, hues: tuple[float, ...]) -> Scene:
        return Scene(
            role,
            tuple(
                SceneObject(f"{prefix}{k}", (0.5, 0.1 * k, 0.05), (0.08, 0.08, 0.1), hue=h, volume=1e-4)
                for k, h in enumerate(hues)
            ),
        )

    source = scene(Role.SOURCE, "s", (0.0, 130.0, 240.0, 60.0))
    target = scene(Role.TARGET, "t", (10.0, 260.0, 130.0, 75.0))
    claims = [("s0", "t0"), ("s1", "t1"), ("s2", "t2")]
    for strategy in STRATEGIES:
        found = {
            (infer(task_over(source), target, [Assist(*c) for c in order], MappingConfig(strategy=strategy)))
            for order in itertools.permutations(claims)
        }
        assert (
            len({(f.mapping.pairs, f.winning, round(f.confidence, 9), round(f.mapping.score, 9)) for f in found}) == 1
        )
