"""Earlier sessions of a lab help where its tasks are alike, and a history that says nothing does no harm."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mbd_experiments.simulated_problems.ground_truth import best_mapping
from mbd_experiments.user_study.cases import Case
from mbd_experiments.user_study.lab_history import HistoryScore, ends_of, left_out, shuffled
from mbd_experiments.user_study.lab_prior_command import learned, main, write_parameters
from mbd_experiments.user_study.study_facts import Origin
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import compare
from mbd_mapping.parameters import MAPPING, mapping_config
from mbd_mapping.similarity import HUE
from mbd_mapping.synthetic import random_problem
from mbd_mapping.teachers.lab_prior import FEATURES, LabPrior
from mbd_model.assists import Assist
from mbd_model.task import StepKind, Task, TaskStep
from rich.console import Console

BAGS = Path(__file__).resolve().parents[2] / "bags"
CONFIG = MappingConfig(strategy="evidence")


def lesson(number: int) -> Case:
    """A session of a lab that sorts by hue: five objects, and every assist."""
    rng = np.random.default_rng([7, number])
    source, target = random_problem(rng, 5)
    columns = best_mapping(compare(source, target, CONFIG), (HUE,))[1]
    pairs = [(s, target.ids[c]) for s, c in zip(source.ids, columns, strict=True)]
    steps = tuple(
        TaskStep(index=k, kind=StepKind.PLACE if k % 2 else StepKind.PICK, primary_object=s, distance=0.0)
        for k, (s, _) in enumerate(pairs)
    )
    return Case(
        name=f"p{number // 2}_s{number % 2}",
        participant=f"p{number // 2}",
        task_name="by hue",
        origin=Origin.SIMULATED,
        task=Task(source, steps),
        target=target,
        assists=tuple(Assist(s, t, k) for k, (s, t) in enumerate(pairs)),
        acceptable={s: frozenset({t}) for s, t in pairs},
        script=(),
        config=CONFIG,
    )


@pytest.fixture(scope="module")
def lab() -> tuple[Case, ...]:
    """Six participants, two sessions each."""
    return tuple(lesson(number) for number in range(12))


@pytest.fixture(scope="module")
def alone(lab: tuple[Case, ...]) -> HistoryScore:
    """How the best guess fares without any history."""
    return left_out(lab, None, CONFIG)


def test_a_lab_whose_tasks_are_alike_is_learned(lab: tuple[Case, ...], alone: HistoryScore) -> None:
    """With the others' sessions right mappings are more probable, and no fewer right after any number of assists."""
    taught = left_out(lab, ends_of(lab, CONFIG), CONFIG)
    assert taught.log_probability > alone.log_probability + 0.05
    assert taught.right[0] > alone.right[0]
    assert all(after >= before for after, before in zip(taught.right, alone.right, strict=True))
    assert taught.informs > 0.5


def test_a_history_of_random_features_does_no_harm(lab: tuple[Case, ...], alone: HistoryScore) -> None:
    """Averaged over shuffles, right mappings are about as probable as without a history."""
    ends, rng = ends_of(lab, CONFIG), np.random.default_rng(1)
    scores = [left_out(lab, shuffled(ends, rng), CONFIG) for _ in range(4)]
    assert np.mean([s.log_probability for s in scores]) >= alone.log_probability - 0.02
    assert np.mean([s.informs for s in scores]) < 0.3


def test_the_more_even_a_history_the_less_it_says() -> None:
    """Twelve sessions of one feature raise its weight; as many of every feature leave all weights equal."""
    one = LabPrior((12.0, 0, 0, 0, 0, 0, 0), 12)
    even = LabPrior((12.0 / 7,) * 7, 12)
    assert one.informs > 0.99
    assert even.informs < 0.2
    assert one.applied_to(CONFIG).priors.features[0] > 4.0
    assert even.applied_to(CONFIG).priors.features == pytest.approx((1.0,) * 7)
    assert sum(one.applied_to(CONFIG).priors.features) == pytest.approx(7.0)
    assert LabPrior().applied_to(CONFIG) == CONFIG


def test_what_is_learned_reaches_the_node_by_its_parameters(tmp_path: Path) -> None:
    """The parameter file makes the configuration that the prior makes, rounded."""
    prior = LabPrior((5.0, 1, 0, 0, 0, 2, 0), 8, 40, 3)
    path = tmp_path / "lab_prior.yaml"
    write_parameters(prior, path)
    made, wanted = mapping_config(MAPPING.in_file(path) | {"strategy": "evidence"}), prior.applied_to(CONFIG)
    assert made.priors.features == pytest.approx(wanted.priors.features, abs=1e-4)
    assert made.assist_error == pytest.approx(wanted.assist_error, abs=1e-4)
    assert replace(made, priors=wanted.priors, assist_error=wanted.assist_error) == wanted


def test_bags_are_learned_from_without_knowing_what_is_right() -> None:
    """Every sample session that came to an assist counts once; learning more adds to what was known."""
    prior = learned([BAGS], Console(file=io.StringIO()))
    assert prior.sessions > 0
    assert prior.assists > 0
    assert sum(prior.uses) == pytest.approx(prior.sessions, abs=1e-9)
    twice = learned([BAGS], Console(file=io.StringIO()), prior)
    assert twice.sessions == 2 * prior.sessions
    assert twice.uses == pytest.approx([2 * u for u in prior.uses])


def test_a_folder_without_sessions_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, exit code 2, nothing written."""
    monkeypatch.setattr("sys.argv", ["lab_prior", str(tmp_path), "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "neither the public study folder nor a folder of session bags" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_features_are_drawn_anew_in_a_shuffled_history(lab: tuple[Case, ...]) -> None:
    """As many features a session as before, all of them existing ones."""
    ends = ends_of(lab[:4], CONFIG)
    drawn = shuffled(ends, np.random.default_rng(2))
    assert {n: len(e.winning) for n, e in drawn.items()} == {n: len(e.winning) for n, e in ends.items()}
    assert {f for e in drawn.values() for f in e.winning} <= set(FEATURES)
