"""One inference from names to names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.config import ConfigError, FeatureSpace, MappingConfig
from mbd_mapping.inference import STRATEGIES, UnknownStrategyError, infer
from mbd_mapping.synthetic import random_scene
from mbd_model.assists import Assist
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

strategies = pytest.mark.parametrize("strategy", sorted(STRATEGIES))


def task_of(source: Scene) -> Task:
    """A task that picks every object once."""
    return Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(source.ids)))


@pytest.fixture
def rng() -> np.random.Generator:
    """Fixed randomness."""
    return np.random.default_rng(7)


@strategies
@given(seed=st.integers(0, 2**32))
def test_relabelling_the_objects_relabels_the_answer(strategy: str, seed: int) -> None:
    """Other names and another order of the objects change nothing but the names in the answer."""
    rng = np.random.default_rng(seed)
    source, target = random_scene(rng, Role.SOURCE, 5, "s"), random_scene(rng, Role.TARGET, 5, "t")
    config = MappingConfig(strategy=strategy)
    assists = [Assist("s1", "t2")]
    before = infer(task_of(source), target, assists, config)

    def renamed(original: Scene) -> Scene:
        order = rng.permutation(len(original.objects))
        objects = [original.objects[k] for k in order]
        return Scene(
            original.role,
            tuple(
                replace(o, object_id=f"new_{o.object_id}", relations=tuple((r, f"new_{i}") for r, i in o.relations))
                for o in objects
            ),
        )

    after = infer(task_of(renamed(source)), renamed(target), [Assist("new_s1", "new_t2")], config)
    if before.ties == 1:
        assert after.mapping.as_dict == {f"new_{s}": f"new_{t}" for s, t in before.mapping.pairs}
    assert after.confidence == pytest.approx(before.confidence, abs=1e-9)


@given(seed=st.integers(0, 2**32), assisted=st.integers(0, 5))
def test_the_prediction_holds_every_assist(seed: int, assisted: int) -> None:
    """The paper's rule never predicts a mapping that contradicts an assist."""
    rng = np.random.default_rng(seed)
    source, target = random_scene(rng, Role.SOURCE, 5, "s"), random_scene(rng, Role.TARGET, 5, "t")
    assists = [Assist(f"s{k}", f"t{c}") for k, c in enumerate(rng.permutation(5)[:assisted])]
    mapping = infer(task_of(source), target, assists, MappingConfig("mbd")).mapping.as_dict
    assert all(mapping[a.source_id] == a.target_id for a in assists)


@strategies
@pytest.mark.parametrize(("n", "m"), [(3, 6), (6, 3), (1, 1), (0, 3), (3, 0), (0, 0)])
def test_scenes_of_different_size_map_what_they_can(strategy: str, n: int, m: int, rng: np.random.Generator) -> None:
    """Distractors and missing objects give a partial mapping with a confidence, not an exception."""
    source, target = random_scene(rng, Role.SOURCE, n, "s"), random_scene(rng, Role.TARGET, m, "t")
    for space in FeatureSpace:
        estimate = infer(task_of(source), target, [], MappingConfig(strategy=strategy, feature_space=space))
        assert len(estimate.mapping.pairs) == min(n, m)
        assert len({t for _, t in estimate.mapping.pairs}) == min(n, m)
        assert 0.0 <= estimate.confidence <= 1.0
        assert estimate.confidence == 0.0 or min(n, m) > 0


@strategies
def test_an_unknown_object_is_ignored_with_a_warning(strategy: str, rng: np.random.Generator) -> None:
    """An assist of an object no scene has changes nothing but the warnings."""
    source, target = random_scene(rng, Role.SOURCE, 4, "s"), random_scene(rng, Role.TARGET, 4, "t")
    config = MappingConfig(strategy=strategy)
    good = [Assist("s0", "t1")]
    plain = infer(task_of(source), target, good, config)
    noisy = infer(task_of(source), target, [Assist("ghost", "t0"), *good, Assist("s1", "phantom")], config)
    assert noisy == replace(plain, num_assists=3, warnings=noisy.warnings)
    assert len(noisy.warnings) == 2
    assert "ghost" in noisy.warnings[0]
    assert "phantom" in noisy.warnings[1]


@strategies
def test_contradicting_assists_are_reported(strategy: str, rng: np.random.Generator) -> None:
    """An assist that contradicts an earlier one is named on the estimate; a repeated one is not."""
    source, target = random_scene(rng, Role.SOURCE, 4, "s"), random_scene(rng, Role.TARGET, 4, "t")
    assists = [Assist("s0", "t1"), Assist("s0", "t1"), Assist("s0", "t2"), Assist("s1", "t1")]
    warnings = infer(task_of(source), target, assists, MappingConfig(strategy=strategy)).warnings
    assert len(warnings) == 2
    assert all("contradicts" in w for w in warnings)


def test_identical_scenes_tie(rng: np.random.Generator) -> None:
    """Objects that differ in nothing give as many tied mappings as there are, and a mapping all the same."""
    twin = SceneObject("a", (0.5, 0.0, 0.0), (0.1, 0.1, 0.1), hue=10.0)
    source = Scene(Role.SOURCE, (twin, replace(twin, object_id="b"), replace(twin, object_id="c")))
    target = Scene(Role.TARGET, source.objects)
    assert infer(task_of(source), target, [], MappingConfig("mbd")).ties == 6
    assert infer(task_of(source), target, [], MappingConfig("mbd", max_ties=4)).ties == 4


def test_several_steps_on_one_object_are_one_correspondence(rng: np.random.Generator) -> None:
    """An object that several steps use is mapped, and asked about, once."""
    source, target = random_scene(rng, Role.SOURCE, 3, "s"), random_scene(rng, Role.TARGET, 3, "t")
    steps = tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(["s2", "s0", "s2", "s0"]))
    estimate = infer(Task(source, steps), target, [Assist("s2", "t0", 0), Assist("s2", "t0", 2)], MappingConfig())
    assert len(estimate.mapping.pairs) == 3
    assert estimate.next_question == "s0"
    assert not estimate.warnings


def test_unknown_strategy() -> None:
    """A strategy that does not exist is refused with the names of those that do."""
    source = Scene(Role.SOURCE, ())
    with pytest.raises(UnknownStrategyError, match="mbd"):
        infer(Task(source, ()), Scene(Role.TARGET, ()), [], MappingConfig(strategy="psychic"))


@pytest.mark.parametrize(
    ("name", "value"), [("sigma", 0.0), ("threshold", 1.5), ("hue_tolerance", -1.0), ("max_ties", 0)]
)
def test_config_is_validated(name: str, value: float) -> None:
    """A constant out of range is refused by its name."""
    with pytest.raises(ConfigError, match=name):
        replace(MappingConfig(), **{name: value})
