"""Experiments 2 and 3 on sessions with known truth, from bags to tables and figures."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_to_bag
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag_writer import BagWriter
from mbd_experiments.csv_table import read_csv, write_csv
from mbd_experiments.reproduction.figures import draw_figure9, draw_figure10
from mbd_experiments.user_study import experiment2, experiment3
from mbd_experiments.user_study.assists_needed import figure9
from mbd_experiments.user_study.cases import Case, case_of_session, read_cases
from mbd_experiments.user_study.consistency import assists_consistent, demonstration_consistent
from mbd_experiments.user_study.predictions import SessionPrediction, predict, read_predictions, write_predictions
from mbd_experiments.user_study.study_facts import SCRIPT, Origin
from mbd_experiments.user_study.study_tables import solutions, table4, table5
from mbd_experiments.user_study.thresholds import THRESHOLDS, best_thresholds, figure10, stop
from mbd_mapping.config import MappingConfig
from mbd_model.assists import Assist
from mbd_study.synthetic import session

SCRIPT_TEXT = "true_s1>true_s4 true_s2>true_s5 true_s3>true_s6"


def recorded(seed: int, **facts: str) -> RecordedSession:
    made = session(f"p{seed}", np.random.default_rng(seed), num_assists=6, config=MappingConfig(threshold=0.02))
    return replace(made.recorded, facts={**made.recorded.facts, SCRIPT: SCRIPT_TEXT, **facts})


@pytest.fixture(scope="module")
def cases() -> tuple[Case, ...]:
    return tuple(case_of_session(recorded(seed)) for seed in range(4))


@pytest.fixture(scope="module")
def predictions(cases: tuple[Case, ...], tmp_path_factory: pytest.TempPathFactory) -> tuple[SessionPrediction, ...]:
    return read_predictions(write_predictions(cases, tmp_path_factory.mktemp("out") / "predictions.csv"))


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags")
    for seed in range(3):
        with BagWriter(folder / f"p{seed}") as bag:
            session_to_bag(recorded(seed), bag)
    return folder


def test_predictions_come_back_from_their_file_as_they_were(
    cases: tuple[Case, ...], predictions: tuple[SessionPrediction, ...]
):
    made = tuple(p for strategy in ("mbd", "evidence") for c in cases for p in predict(c, strategy))
    assert predictions == made


def test_once_right_stays_within(predictions: tuple[SessionPrediction, ...]):
    rows = figure9(predictions)
    for before, after in pairwise(rows):
        if before["task"] == after["task"] and before["strategy"] == after["strategy"]:
            assert int(after["within"]) >= int(before["within"])
    assert all(int(r["correct"]) <= int(r["within"]) <= int(r["sessions"]) for r in rows)
    assert all(r["within"] == r["unguided"] for r in rows if r["assists"] == 0)


def test_relearning_is_right_exactly_when_every_step_was_shown(predictions: tuple[SessionPrediction, ...]):
    for row in figure9(predictions):
        assert row["relearning"] == (4 if int(row["assists"]) >= 6 else 0)


def test_a_higher_threshold_never_asks_less(predictions: tuple[SessionPrediction, ...]):
    rows = [r for r in figure10(predictions) if r["policy"] == "confident" and r["task"] == "all"]
    for strategy, thresholds in THRESHOLDS.items():
        asked = [float(r["assists"]) for r in rows if r["strategy"] == strategy]
        assert len(asked) == len(thresholds)
        assert asked == sorted(asked)
        assert asked[0] == 0.0


@given(st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1, max_size=8), st.floats(0, 1))
def test_the_robot_stops_at_the_first_confident_estimate(entries: list[tuple[float, bool]], threshold: float):
    made = [
        SessionPrediction(Origin.SIMULATED, "mbd", "sorting", "p", "p", 6, k, right, confidence, 1, "hue")
        for k, (confidence, right) in enumerate(entries)
    ]
    found = stop(made, threshold)
    assert all(p.confidence < threshold for p in made[: found.assists])
    assert found.confidence >= threshold or found is made[-1]


def test_the_best_threshold_gets_most_right_with_fewest_assists(predictions: tuple[SessionPrediction, ...]):
    rows = figure10(predictions)
    for best in best_thresholds(rows):
        others = [
            r
            for r in rows
            if r["policy"] == "confident" and (r["strategy"], r["task"]) == (best["strategy"], best["task"])
        ]
        assert all(
            (-int(best["correct"]), float(best["assists"])) <= (-int(r["correct"]), float(r["assists"])) for r in others
        )


def test_a_session_that_did_as_asked_is_consistent(cases: tuple[Case, ...], predictions: tuple[SessionPrediction, ...]):
    assert all(demonstration_consistent(c) and assists_consistent(c) for c in cases)
    for row in table5(cases, predictions):
        assert (row["consistent_demonstrations"], row["consistent_assists"], row["both_consistent"]) == (4, 4, 4)


def test_pairs_in_another_order_are_consistent_and_a_wrong_pair_is_not(cases: tuple[Case, ...]):
    case, (one, two, three) = cases[0], cases[0].script
    assert demonstration_consistent(replace(case, script=(three, one, two)))
    assert not demonstration_consistent(replace(case, script=((one[0], two[1]), (two[0], one[1]), three)))


def test_assists_in_another_order_than_the_demonstration_are_not_consistent(cases: tuple[Case, ...]):
    case = cases[0]
    first, second, third, *rest = case.assists
    swapped = (replace(first, target_id=third.target_id), second, replace(third, target_id=first.target_id), *rest)
    assert not assists_consistent(replace(case, assists=swapped))


def test_a_wrongly_recorded_object_does_not_make_the_assists_inconsistent(cases: tuple[Case, ...]):
    case = cases[0]
    steps = list(case.task.steps)
    # The teacher picked up the second small cup, as asked; the first one was recorded.
    steps[2] = replace(steps[2], primary_object=steps[0].primary_object)
    meant = tuple(Assist("unused", sorted(case.acceptable[name])[0], k) for k, name in enumerate(sum(case.script, ())))
    wrong = replace(case, task=replace(case.task, steps=tuple(steps)), assists=meant)
    assert not demonstration_consistent(wrong)
    assert assists_consistent(wrong)


def test_an_object_put_aside_first_shifts_the_steps_but_not_what_was_meant(cases: tuple[Case, ...]):
    case = cases[0]
    onto = case.script[0][1]
    aside = [replace(step, primary_object=onto) for step in case.task.steps[:2]]
    steps = [replace(s, index=k) for k, s in enumerate([*aside, *case.task.steps])]
    given = tuple(replace(a, step_index=a.step_index + 2) for a in case.assists)
    moved = replace(case, task=replace(case.task, steps=tuple(steps)), assists=given)
    assert not demonstration_consistent(moved)
    assert assists_consistent(moved)


def test_sorting_two_of_a_colour_has_eight_solutions(cases: tuple[Case, ...]):
    row = table4(cases)[0]
    assert (row["solutions"], row["steps"], row["source_objects"], row["sessions"]) == (8, 6, 6, 4)
    assert solutions({"a": frozenset({"x"}), "b": frozenset({"x"})}, ("a", "b")) == 0


def test_each_experiment_is_one_command_on_a_folder_of_bags(
    bags: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    for module, files in (
        (experiment2, {"predictions.csv", "table4.csv", "table5.csv", "figure9.csv", "figure9_simulated.png"}),
        (experiment3, {"predictions.csv", "figure10.csv", "best_thresholds.csv", "figure10_simulated.png"}),
    ):
        name = module.__name__.rpartition(".")[2]
        out = tmp_path / name
        monkeypatch.setattr("sys.argv", [name, str(bags), "--out", str(out)])
        with pytest.raises(SystemExit) as ended:
            module.main()
        assert ended.value.code == 0
        assert {p.name for p in out.iterdir()} == files | {f"{name}.md"}
        assert "Simulated data" in (out / f"{name}.md").read_text()
        assert "3 sessions of simulated data" in capsys.readouterr().out


def test_figures_are_drawn_from_the_table_alone(bags: Path, tmp_path: Path):
    cases, _ = read_cases([bags])
    experiment2.run(cases, tmp_path, ("mbd",))
    experiment3.run(cases, tmp_path, ("mbd",))
    for draw, table in ((draw_figure9, "figure9.csv"), (draw_figure10, "figure10.csv")):
        (first,) = draw(tmp_path / table, tmp_path / "again")
        assert first.read_bytes() == (tmp_path / first.name).read_bytes()
        rows = [{**row, "origin": "real"} for row in read_csv(tmp_path / table)]
        (other,) = draw(write_csv(tmp_path / "other" / table, rows), tmp_path / "other")
        assert other.name == first.name.replace("simulated", "real")
        assert other.read_bytes() != first.read_bytes()


def test_a_bag_that_cannot_be_used_is_named_and_the_others_are(bags: Path, tmp_path: Path):
    for bag in bags.iterdir():
        (tmp_path / bag.name).symlink_to(bag)
    cut = replace(recorded(7), name="cut", tasks=(), estimates=())
    with BagWriter(tmp_path / "cut") as bag:
        session_to_bag(cut, bag)
    cases, left_out = read_cases([tmp_path])
    assert [c.name for c in cases] == ["p0", "p1", "p2"]
    assert [entry.path.name for entry in left_out] == ["cut"]
    assert "ended before the assists" in left_out[0].reason


def test_a_folder_without_sessions_is_refused(tmp_path: Path):
    with pytest.raises(BagError, match="neither the public study folder nor a folder of session bags"):
        read_cases([tmp_path])
