"""The study's own recordings as bags, and experiments 2 and 3 on them."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest
import rclpy
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from mbd_experiments.csv_table import read_csv
from mbd_experiments.public_study.study_folder import StudySession, read_study
from mbd_experiments.user_study import experiment2, experiment3
from mbd_experiments.user_study.cases import read_cases
from mbd_experiments.user_study.import_study import STUDY_CONFIG, import_study
from mbd_mapping.inference import infer
from mbd_model.ros.conversions import assists_to_msg, estimate_from_msg, scene_to_msg, stamp_to_msg, task_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_msgs import msg as m
from mbd_study.recompute.reevaluation import differences, reevaluate
from rclpy.executors import SingleThreadedExecutor

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def study() -> Path:
    folder = Path(__file__).resolve().parents[3] / "shared" / "hri17"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent: the study's data is kept outside the repository")
    return folder


@pytest.fixture(scope="module")
def files(study: Path) -> dict[str, StudySession]:
    return {s.name: s for s in read_study(study)}


@pytest.fixture(scope="module")
def imported(study: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The study as a folder of bags."""
    folder = tmp_path_factory.mktemp("hri17")
    import_study(study, folder)
    return folder


@pytest.fixture(scope="module")
def bags(imported: Path) -> dict[str, RecordedSession]:
    return {p.name: session_from_bag(Bag(p)) for p in imported.iterdir()}


def test_every_bag_reevaluates_to_what_the_mapping_computes_from_the_files(
    files: dict[str, StudySession], bags: dict[str, RecordedSession]
):
    assert set(files) == set(bags)
    for name, session in files.items():
        comparisons = reevaluate(bags[name])
        assert [c.recorded.value.num_assists for c in comparisons] == list(range(len(session.assists) + 1))
        for count, entry in enumerate(comparisons):
            assert entry.computed is not None
            direct = infer(session.task, session.target, session.assists[:count], STUDY_CONFIG)
            assert differences(direct, entry.computed) == (), (name, count)
            assert entry.agrees, (name, count)


def test_a_bag_played_to_the_mapping_node_makes_it_publish_what_the_bag_holds(
    bags: dict[str, RecordedSession], ros_domain: int
):
    session = bags["u2_t0"]
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("player", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    received: list[m.MappingEstimate] = []
    node.create_subscription(m.MappingEstimate, "mapping/estimate", received.append, LATCHED)
    task = node.create_publisher(m.Task, "demonstration/task", LATCHED)
    target = node.create_publisher(m.Scene, "perception/target_scene", LATCHED)
    assists = node.create_publisher(m.Assists, "interaction/assists", LATCHED)
    parameters = ["-p", "strategy:=mbd", "-p", "missing_hue:=as_recorded"]
    command = [sys.executable, "-m", "mbd_mapping.ros.node", "--ros-args", *parameters]
    process = subprocess.Popen(command, env={**os.environ, "ROS_DOMAIN_ID": str(ros_domain)})
    try:
        task.publish(task_to_msg(session.tasks[0].value))
        target.publish(scene_to_msg(session.target_scenes[0].value))
        for told, (recorded, inputs) in zip(session.assists, session.estimates, strict=True):
            message = assists_to_msg(told.value, told.stamp / 1e9, session.name)
            message.header.stamp = stamp_to_msg(told.stamp)
            assists.publish(message)
            end = time.monotonic() + 120.0  # patience for a process that starts; no claim about its speed
            while not received or received[-1].assists_stamp != stamp_to_msg(inputs.assists_stamp):
                assert process.poll() is None, "the node died"
                assert time.monotonic() < end, "no estimate came"
                executor.spin_once(timeout_sec=0.1)
            assert differences(recorded.value, estimate_from_msg(received[-1])) == ()
    finally:
        process.terminate()
        process.wait(10)
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown(context=context)


# What PAPER.md's section 6 states of all 30 sessions. The half of them here gives the numbers of hri17/README.md.
ALL = 30
CORRECT = {
    15: {"stacking": [4, 5, 4, 3, 3], "sorting": [2, 3, 4, 3, 3], "lunch_packing": [5, 5, 5, 5, 5]},
    ALL: {"stacking": [6, 8, 8, 7, 7], "sorting": [4, 6, 7, 6, 5], "lunch_packing": [10, 9, 9, 9, 9]},
}
WITHIN = {"stacking": [6, 8, 9, 9, 9], "sorting": [4, 7, 8, 9, 9], "lunch_packing": [10, 10, 10, 10, 10]}
BY_THRESHOLD = {
    "0": (20, 0.0),
    "0.005": (22, 0.23),
    "0.01": (27, 0.47),
    "0.015": (28, 0.53),
    "0.02": (27, 0.73),
    "0.05": (26, 1.33),
    "0.1": (26, 1.67),
    "0.25": (22, 3.37),
}
TASK_OF = {"t0": "stacking", "t1": "sorting", "t2": "lunch_packing"}


@dataclass(frozen=True)
class Reading:
    """One session in the independent reading: right or not and how sure after 0, 1, ... assists; its steps."""

    task: str
    right: list[int]
    confidence: list[float]
    steps: int

    def stop(self, threshold: float) -> int:
        """Assists until the confidence reaches the threshold, all of them if it never does."""
        return next((k for k, c in enumerate(self.confidence) if c >= threshold), len(self.right) - 1)


@pytest.fixture(scope="module")
def readings(study: Path) -> list[Reading]:
    """Of expected.csv and the folder's own lines: nothing of this project takes part in it."""
    rows: dict[str, list[dict[str, str]]] = {}
    for row in csv.DictReader((study / "expected.csv").read_text().splitlines()):
        rows.setdefault(row["session"], []).append(row)
    found = []
    for name, own in rows.items():
        assert [int(r["assists"]) for r in own] == list(range(len(own)))
        steps = len((study / name / "targeters.txt").read_text().split("\n(")) - 1
        right, confidence = [int(r["correct"]) for r in own], [float(r["confidence"]) for r in own]
        found.append(Reading(TASK_OF[name[-2:]], right, confidence, steps))
    return found


@pytest.fixture(scope="module")
def tables(study: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Experiments 2 and 3 by the paper's rule."""
    out = tmp_path_factory.mktemp("experiments")
    cases, left_out = read_cases([study])
    assert left_out == ()
    experiment2.run(cases, out, ("mbd",))
    experiment3.run(cases, out, ("mbd",))
    return out


def test_figure_9_is_that_of_the_independent_reading(readings: list[Reading], tables: Path):
    rows = read_csv(tables / "figure9.csv")
    assert {r["task"] for r in rows} == {r.task for r in readings}
    for row in rows:
        k, own = int(row["assists"]), [r for r in readings if r.task == row["task"]]
        assert int(row["sessions"]) == len(own)
        assert int(row["correct"]) == sum(r.right[min(k, len(r.right) - 1)] for r in own)
        assert int(row["within"]) == sum(any(r.right[: k + 1]) for r in own)
        assert int(row["unguided"]) == sum(r.right[0] for r in own)
        assert int(row["relearning"]) == sum(k >= r.steps for r in own)


def test_figure_10_is_that_of_the_independent_reading(readings: list[Reading], tables: Path):
    rows = [r for r in read_csv(tables / "figure10.csv") if r["policy"] == "confident"]
    assert {float(r["threshold"]) for r in rows} >= {float(t) for t in BY_THRESHOLD}
    for row in rows:
        own = [r for r in readings if row["task"] in (r.task, "all")]
        stops = [r.stop(float(row["threshold"])) for r in own]
        assert int(row["correct"]) == sum(r.right[k] for r, k in zip(own, stops, strict=True))
        assert float(row["assists"]) == pytest.approx(sum(stops) / len(own), abs=1e-5)
        autonomy = [max(0.0, 1 - k / r.steps) for r, k in zip(own, stops, strict=True)]
        assert float(row["autonomy"]) == pytest.approx(sum(autonomy) / len(own), abs=1e-5)


def test_the_best_threshold_is_that_of_the_independent_reading(readings: list[Reading], tables: Path):
    def score(threshold: float) -> tuple[int, float]:
        stops = [r.stop(threshold) for r in readings]
        return sum(r.right[k] for r, k in zip(readings, stops, strict=True)), -sum(stops) / len(stops)

    scores = {k / 200: score(k / 200) for k in range(51)}
    best = next(r for r in read_csv(tables / "best_thresholds.csv") if r["task"] == "all")
    assert scores[float(best["threshold"])] == max(scores.values())
    assert (int(best["correct"]), float(best["assists"])) == pytest.approx(
        (max(scores.values())[0], -max(scores.values())[1]), abs=1e-5
    )


def test_the_numbers_are_those_that_the_paper_page_prints(readings: list[Reading], tables: Path):
    if len(readings) not in CORRECT:
        pytest.skip(f"{len(readings)} sessions are there; numbers are printed of {sorted(CORRECT)} only")
    rows = read_csv(tables / "figure9.csv")
    for task, correct in CORRECT[len(readings)].items():
        assert [int(r["correct"]) for r in rows if r["task"] == task][:5] == correct
    at = {r["threshold"]: r for r in read_csv(tables / "figure10.csv") if r["task"] == "all"}
    if len(readings) == ALL:
        for task, within in WITHIN.items():
            assert [int(r["within"]) for r in rows if r["task"] == task][:5] == within
        for threshold, (correct, assists) in BY_THRESHOLD.items():
            assert int(at[threshold]["correct"]) == correct
            assert float(at[threshold]["assists"]) == pytest.approx(assists, abs=0.005)
    else:
        assert (at["0.015"]["correct"], at["0.015"]["assists"]) == ("14", "0.4")


def test_the_tasks_are_those_of_the_paper_and_consistent_data_is_mapped(readings: list[Reading], tables: Path):
    table = {r["task"]: (r["source_objects"], r["steps"], r["solutions"]) for r in read_csv(tables / "table4.csv")}
    assert table == {"stacking": ("5", "8", "1"), "sorting": ("6", "6", "8"), "lunch_packing": ("4", "6", "1")}
    for row in read_csv(tables / "table5.csv"):
        assert 0 < int(row["mapped_of_both"]) <= int(row["both_consistent"])
        # The paper's criteria are not published; by ours it holds on the half that is public here.
        assert len(readings) > 15 or row["mapped_of_both"] == row["both_consistent"]


@pytest.mark.parametrize("participants", [("u7",), ("u2", "u6"), ("u5", "u4", "u7")])
def test_of_other_participants_each_session_gives_the_same(
    participants: tuple[str, ...], study: Path, tables: Path, tmp_path: Path
):
    """A part of the sessions, its participants numbered again up to u10: nothing hangs on who is there."""
    names = {old: f"u{10 - k}" for k, old in enumerate(participants)}
    for folder in ("knowledge", "solutions"):
        (tmp_path / "study").mkdir(exist_ok=True)
        (tmp_path / "study" / folder).symlink_to(study / folder)
    present = [p for p in study.glob("u*_t*") if p.name.partition("_")[0] in names]
    if len(present) < len(participants):
        pytest.skip(f"none of {participants} is in {study}")
    for path in present:
        old, _, task = path.name.partition("_")
        (tmp_path / "study" / f"{names[old]}_{task}").symlink_to(path)
    cases, _ = read_cases([tmp_path / "study"])
    assert len(cases) == len(present)
    experiment2.run(cases, tmp_path / "out", ("mbd",))
    of_all = {(r["session"], r["assists"]): r for r in read_csv(tables / "predictions.csv")}
    back = {new: old for old, new in names.items()}
    for row in read_csv(tmp_path / "out" / "predictions.csv"):
        who, _, task = row["session"].partition("_")
        expected = {**of_all[f"{back[who]}_{task}", row["assists"]], "session": row["session"], "participant": who}
        assert row == expected


def test_files_and_bags_give_the_same_tables(imported: Path, tables: Path, tmp_path: Path):
    experiment2.run(read_cases([imported])[0], tmp_path, ("mbd",))
    for table in ("predictions.csv", "table4.csv", "table5.csv", "figure9.csv"):
        assert read_csv(tmp_path / table) == read_csv(tables / table), table
