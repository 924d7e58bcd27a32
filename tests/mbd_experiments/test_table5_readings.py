"""Which ways of judging consistency can give the cells of the paper's Table 5."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_experiments.public_study.study_folder import StudySession
from mbd_experiments.public_study.table5_readings import (
    ASSISTS,
    DEMONSTRATIONS,
    TableReading,
    can_become,
    main,
    possible_of,
)
from mbd_experiments.user_study.study_facts import TASK_NAMES
from mbd_mapping.synthetic import random_scene
from mbd_model.objects import Role
from mbd_model.task import StepKind, Task, TaskStep

SCRIPT = (("s0", "s3"), ("s1", "s3"))
SOLUTION = {"s0": frozenset({"t0", "t1"}), "s1": frozenset({"t2"}), "s3": frozenset({"t3"})}


def session(steps: str, hints: str) -> StudySession:
    """A session of four objects: who was picked and placed onto, and the raw hints."""
    scene = random_scene(np.random.default_rng(0), Role.SOURCE, 4, "s")
    target = random_scene(np.random.default_rng(1), Role.TARGET, 4, "t")
    made = tuple(
        TaskStep(index=k, kind=StepKind.PLACE if k % 2 else StepKind.PICK, primary_object=name, distance=0.0)
        for k, name in enumerate(steps.split())
    )
    return StudySession("u1_t0", Task(scene, made), target, (), SOLUTION, tuple(hints.split()))


@given(
    kinds=st.lists(st.tuples(st.booleans(), st.booleans()), max_size=5),
    wanted=st.tuples(st.integers(0, 10), st.integers(0, 10), st.integers(0, 10)),
)
def test_what_can_become_of_a_part_is_what_some_rest_makes(
    kinds: list[tuple[bool, bool]], wanted: tuple[int, int, int]
) -> None:
    """Possible exactly when some five other sessions, consistent or not in each respect, make up the wanted cells."""

    def cells(sessions: list[tuple[bool, bool]]) -> tuple[int, int, int]:
        return sum(d for d, _ in sessions), sum(a for _, a in sessions), sum(d and a for d, a in sessions)

    rest = 10 - len(kinds)
    counts = (c for c in itertools.product(range(rest + 1), repeat=3) if sum(c) <= rest)
    found = any(
        cells(kinds + [(True, False)] * shown + [(False, True)] * helped + [(True, True)] * both) == wanted
        for shown, helped, both in counts
    )
    assert can_become(cells(kinds), len(kinds), wanted) == found


@pytest.mark.parametrize(
    ("steps", "judged"),
    [
        ("s0 s3 s1 s3", {"script's order", "any order", "every pair, and more", "picks in order", "objects used"}),
        ("s1 s3 s0 s3", {"any order", "every pair, and more", "objects used"}),
        ("s0 s3 s1 s3 s1 s3", {"every pair, and more", "objects used"}),
        ("s0 s3 s1 s0", {"picks in order", "objects used"}),
        ("s0 s3", set()),
    ],
)
def test_demonstrations_are_judged_by_what_was_placed_onto_what(steps: str, judged: set[str]) -> None:
    """Each criterion takes what it says, and no other."""
    assert {name for name, judge in DEMONSTRATIONS.items() if judge(session(steps, "t0 t3"), SCRIPT)} == judged


@pytest.mark.parametrize(
    ("steps", "hints", "taken", "refused"),
    [
        ("s1 s3 s0 s3", "t2 t3 t1 t3", {"each, as recorded", "two by two, in any order"}, {"each, as scripted"}),
        ("s1 s3 s0 s3", "t0 t3 t2 t3", {"each, as scripted", "first two"}, {"each, as recorded"}),
        ("s0 s3 s1 s3", "t0 t3 t0 t3 t2 t3", {"two by two, in any order"}, {"each, as recorded"}),
        ("s0 s3 s1 s3", "t0 t0 t3 t2 t3", {"each, as recorded, repeats left out"}, {"first two"}),
        ("s0 s3 s1 s3", "t0 t3", {"each, as recorded", "first two"}, {"two by two, in any order"}),
    ],
)
def test_assists_are_judged_from_the_raw_hints(steps: str, hints: str, taken: set[str], refused: set[str]) -> None:
    """Order, repeats and what the hints are held against are what tells the criteria apart."""
    judged = {name for name, judge in ASSISTS.items() if judge(session(steps, hints), SCRIPT)}
    assert taken <= judged
    assert not refused & judged


def test_a_way_of_judging_must_be_possible_for_every_task() -> None:
    """One task that cannot come out excludes the way, whatever the others give."""

    def reading(task: str, shown: str, possible: bool) -> TableReading:
        return TableReading(task, (), shown, "first two", (0, 0, 0), 0, 5, possible)

    found = [reading(task, "any order", task != "sorting") for task in TASK_NAMES]
    found += [reading(task, "objects used", True) for task in TASK_NAMES]
    assert [way[0].demonstrations for way in possible_of(found)] == ["objects used"]


def test_a_folder_without_sessions_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, exit code 2."""
    monkeypatch.setattr("sys.argv", ["table5_readings", str(tmp_path)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "no session folder such as u2_t0" in capsys.readouterr().err
