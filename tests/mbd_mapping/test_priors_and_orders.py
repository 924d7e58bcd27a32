"""Beliefs about teachers before any assist: orders, weights, promises and what a lab has learned."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.assignment.assignment import best_assignment
from mbd_mapping.config import ConfigError, FeatureSpace, MappingConfig
from mbd_mapping.evidence import infer_evidence
from mbd_mapping.inference import infer
from mbd_mapping.parameters import MAPPING, mapping_config
from mbd_mapping.similarity import HUE, SIZE, Comparison
from mbd_mapping.stopping.promise import PromiseCalibration, critical_of
from mbd_mapping.synthetic import random_problem, random_scene
from mbd_mapping.tables import ObjectTable
from mbd_mapping.teachers.hypotheses import GROUPS, Hypotheses
from mbd_mapping.teachers.lab_prior import LabPrior, LabPriorError
from mbd_mapping.teachers.noise import layer_noise
from mbd_mapping.teachers.orders import order_scores
from mbd_mapping.teachers.priors import FITTED, Group, PriorError
from mbd_mapping.teachers.weighing import spread_weights, weight_vectors
from mbd_model.assists import Assist
from mbd_model.objects import FeatureDeviations, Role, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

EVIDENCE = MappingConfig(strategy="evidence")


def tables(seed: int, size: int = 6) -> tuple[ObjectTable, ObjectTable]:
    """A problem of experiment 1."""
    source, target = random_problem(np.random.default_rng(seed), size)
    return ObjectTable.of(source.objects), ObjectTable.of(target.objects)


@given(seed=st.integers(0, 2**32))
def test_the_order_of_places_maps_first_to_first(seed: int) -> None:
    """Left to right and near to far are among the orders, exactly as sorting gives them."""
    source, target = tables(seed)
    assert source.positions is not None
    assert target.positions is not None
    found = {tuple(best_assignment(score).tolist()) for group, score in order_scores(source, target)}
    for axis, sign in ((1, -1.0), (0, 1.0)):
        a, b = sign * source.positions[:, axis], sign * target.positions[:, axis]
        if min(np.diff(np.sort(a)).min(), np.diff(np.sort(b)).min()) < 0.03:
            continue  # closer than their places are measured: their order is not sure
        columns = np.empty(6, dtype=int)
        columns[np.argsort(a)] = np.argsort(b)
        assert tuple(columns.tolist()) in found


@given(seed=st.integers(0, 2**32), n=st.integers(2, 6), m=st.integers(2, 6))
def test_orders_of_scenes_of_different_size_keep_the_order(seed: int, n: int, m: int) -> None:
    """Whatever is mapped by rank of size is mapped in that order."""
    rng = np.random.default_rng(seed)
    source = ObjectTable.of(random_scene(rng, Role.SOURCE, n, "s").objects)
    target = ObjectTable.of(random_scene(rng, Role.TARGET, m, "t").objects)
    score = next(score for group, score in order_scores(source, target) if group == Group.ORDER)
    pairs = (
        [(r, int(c)) for r, c in enumerate(best_assignment(score))]
        if n <= m
        else [(int(r), c) for c, r in enumerate(best_assignment(score.T))]
    )
    for (r1, c1), (r2, c2) in itertools.pairwise(pairs):
        rising = (source.volume[r1] - source.volume[r2]) * (target.volume[c1] - target.volume[c2])
        near = (
            abs(math.log(source.volume[r1] / source.volume[r2])) < 0.3
            or abs(math.log(target.volume[c1] / target.volume[c2])) < 0.3
        )
        assert rising > 0 or near


def test_a_teacher_by_order_is_found_after_two_assists() -> None:
    """Left to right: the rest is right after two assists in most problems, where nothing but order explains them."""
    solved = 0
    for seed in range(20):
        source, target = tables(seed)
        assert source.positions is not None
        assert target.positions is not None
        columns = np.empty(6, dtype=int)
        columns[np.argsort(-source.positions[:, 1])] = np.argsort(-target.positions[:, 1])
        found = infer_evidence(Comparison.of(source, target, EVIDENCE), [(k, int(columns[k])) for k in (0, 3)], ())
        solved += found.columns == tuple(columns.tolist())
    assert solved >= 8


def test_weights_spread_over_the_simplex() -> None:
    """Every feature leads in some of them, and their mean is near even; they are the same every time."""
    weights = spread_weights(32)
    shares = weights / weights.sum(axis=1, keepdims=True)
    assert set(shares.argmax(axis=1)) == set(range(7))
    assert shares.mean(axis=0) == pytest.approx(np.full(7, 1 / 7), abs=0.05)
    assert np.array_equal(weights, spread_weights(32))


@pytest.mark.parametrize("space", list(FeatureSpace))
def test_weights_use_only_what_varies_and_sum_to_one(space: FeatureSpace) -> None:
    """A feature that is the same for all objects is nobody's."""
    varying = np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0])
    for _, weights in weight_vectors(varying, space, 6):
        assert weights.sum() == pytest.approx(1.0)
        assert not weights[varying == 0.0].any()


def test_something_else_is_always_possible() -> None:
    """Every mapping has a probability that is not negligible, whatever the scenes."""
    source, target = tables(3, 5)
    hypotheses = Hypotheses.of(Comparison.of(source, target, EVIDENCE))
    other = math.exp(hypotheses.log_prior[GROUPS.index(Group.OTHER) == hypotheses.group][0]) * math.factorial(5)
    # No set of three or more competes in the feature space "single": its share goes to the others.
    assert other == pytest.approx(FITTED.group(Group.OTHER) / (1.0 - FITTED.group(Group.LARGER)), rel=0.01)


def test_a_prior_that_is_none_is_refused() -> None:
    """Naming what is wrong."""
    with pytest.raises(PriorError, match="other"):
        replace(FITTED, groups=tuple((g, 0.0 if g == Group.OTHER else 1.0) for g in Group))
    with pytest.raises(PriorError, match="features"):
        replace(FITTED, features=(1.0, 0.0))


def test_noise_enters_as_it_is_measured() -> None:
    """Hues measured exactly have what no teacher tells apart; those measured badly more than those measured well."""
    source, target = tables(1)

    def noise(std: float) -> float:
        well = (replace(t, hue_std=np.full(6, std)) for t in (source, target))
        return float(layer_noise(Comparison.of(*well, EVIDENCE))[HUE])

    assert noise(0.0) == EVIDENCE.similarity_noise
    assert noise(0.0) < noise(2.0) < noise(10.0)
    unknown = layer_noise(Comparison.of(source, target, EVIDENCE))
    assert unknown == pytest.approx(np.full(7, EVIDENCE.similarity_noise))


def test_an_object_of_which_nothing_is_said_adds_no_noise() -> None:
    """Object by object: the fewer say how badly they were measured, the less noise, down to the configuration's."""
    source, target = tables(1)

    def noise(unmeasured: int) -> float:
        std = np.full(6, 0.3)
        std[:unmeasured] = np.nan
        known = replace(target, volume_std=np.full(6, 0.3))
        return float(layer_noise(Comparison.of(replace(source, volume_std=std), known, EVIDENCE))[SIZE])

    assert noise(0) > noise(1) > noise(6)
    assert noise(6) == pytest.approx(EVIDENCE.similarity_noise)


def test_the_table_of_a_scene_holds_what_its_objects_state_of_their_measurement() -> None:
    """Volume as a share of itself; NaN for an object that states nothing, 0 for the hue of a grey one."""
    std = FeatureDeviations((0.0,) * 3, (0.0,) * 3, (0.0,) * 3, 0.0, volume=2e-5, hue=3.0, saturation=0.0)
    measured = SceneObject("a", (0.0, 0.0, 0.0), (0.1, 0.1, 0.1), hue=10.0, deviations=std)
    grey = replace(measured, object_id="b", hue=None, deviations=replace(std, hue=None))
    table = ObjectTable.of([measured, grey, replace(measured, object_id="c", deviations=None)])
    assert table.hue_std is not None and table.volume_std is not None
    np.testing.assert_allclose(table.hue_std, [3.0, 0.0, np.nan])
    np.testing.assert_allclose(table.volume_std, [0.02, 0.02, np.nan])
    assert ObjectTable.of([replace(measured, deviations=None)]).volume_std is None


def test_node_and_tools_have_one_configuration() -> None:
    """The node's parameters at their defaults make the configuration that tools and experiments take."""
    defaults = {spec.name: spec.default for spec in MAPPING.specs if spec.name != "threshold"}
    assert mapping_config(defaults) == MappingConfig()


@given(seed=st.integers(0, 2**32), promise=st.sampled_from([0.8, 0.9, 0.95]))
def test_the_promise_is_kept_on_exchangeable_sessions(seed: int, promise: float) -> None:
    """Of new sessions like those calibrated on the promised share has a critical score below the threshold."""
    rng = np.random.default_rng(seed)
    critical = np.sort(rng.random(400))
    calibration = PromiseCalibration(1.0, 0.0, 0.0, (0.0, *critical.tolist()), 400)
    kept = (rng.random(4000) <= calibration.critical_score(promise)).mean()
    # The share kept is beta-distributed: five of its standard deviations, and those of the count.
    assert kept >= promise - 5 * math.sqrt(promise * (1 - promise) * (1 / 400 + 1 / 4000))


def test_too_few_sessions_promise_nothing() -> None:
    """With nine sessions 0.95 cannot be promised: the robot never goes on alone."""
    calibration = PromiseCalibration(1.0, 0.0, 0.0, tuple(k / 9 for k in range(10)), 9)
    assert calibration.threshold(0.95, 2) > 1.0
    assert calibration.threshold(0.5, 2) <= 1.0


def test_the_critical_score_is_that_of_the_surest_wrong_stop() -> None:
    """A wrong state after a surer one is never stopped at; right ones do no harm."""
    assert critical_of([0.2, 0.6, 0.5, 0.9], [False, False, False, True]) == 0.6
    assert critical_of([0.7, 0.6], [True, False]) == 0.0


def test_a_threshold_is_the_confidence_that_reaches_the_score() -> None:
    """The threshold for a promise is where the corrected confidence meets the critical score, however many are left."""
    calibration = PromiseCalibration(0.9, -0.5, 0.3, tuple(k / 100 for k in range(101)), 1000)
    for left in (1, 3, 6):
        at = calibration.threshold(0.9, left)
        assert calibration.score(at, left) == pytest.approx(calibration.critical_score(0.9))


def test_a_lab_prior_survives_its_file(tmp_path: Path) -> None:
    """What is written is read again; what is no lab prior is refused with its path."""
    prior = LabPrior((1.0, 0.0, 2.5, 0.0, 0.0, 0.5, 0.0), 4, 12, 1)
    prior.write(tmp_path / "lab.json")
    assert LabPrior.read(tmp_path / "lab.json") == prior
    (tmp_path / "lab.json").write_text("[]")
    with pytest.raises(LabPriorError, match=r"lab\.json"):
        LabPrior.read(tmp_path / "lab.json")
    with pytest.raises(LabPriorError, match="nowhere"):
        LabPrior.read(tmp_path / "nowhere.json")


def test_a_history_of_nothing_changes_nothing() -> None:
    """No session, or every feature as often as any other: the same configuration."""
    assert LabPrior().applied_to(EVIDENCE) == EVIDENCE
    even = LabPrior((3.0,) * 7, 21, 0, 0).applied_to(EVIDENCE)
    assert even.priors.features == pytest.approx((1.0,) * 7)


def test_a_feature_that_mattered_before_is_believed_more() -> None:
    """After sessions by size, size is likelier to be what matters now."""
    source, target = random_problem(np.random.default_rng(8), 5)
    task = Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(source.ids)))
    by_size = LabPrior((0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 0.0), 10, 20, 0)
    before = infer(task, target, [Assist("s0", "t0")], EVIDENCE)
    after = infer(task, target, [Assist("s0", "t0")], by_size.applied_to(EVIDENCE))
    assert by_size.applied_to(EVIDENCE).assist_error < EVIDENCE.assist_error
    assert after != before


def test_a_promise_takes_the_place_of_the_threshold() -> None:
    """A greater promise asks for more confidence, and the estimate says how much; "mbd" can promise nothing."""
    source, target = random_problem(np.random.default_rng(8), 5)
    task = Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(source.ids)))
    some, more = (infer(task, target, [], replace(EVIDENCE, promise=p)).threshold for p in (0.6, 0.9))
    assert some < more
    assert infer(task, target, [], EVIDENCE).threshold == EVIDENCE.stop_at
    with pytest.raises(ConfigError, match="promise"):
        MappingConfig(strategy="mbd", promise=0.9)
