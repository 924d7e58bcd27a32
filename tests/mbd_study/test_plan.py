"""A plan balances who does what when, refuses what it does not know, and states which session is next."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.ros.session_conversions import session_to_bag
from mbd_bag.session.recorded_session import Recorded
from mbd_bag.storage.bag_writer import BagWriter
from mbd_model.session import Phase
from mbd_study.plan import plan_command
from mbd_study.plan.orders import Order, balanced_at, orders, williams_rows
from mbd_study.plan.protocol import HeldSession, deviations, fidelity, held_sessions, next_session
from mbd_study.plan.schedule import imbalances, planned_sessions
from mbd_study.plan.study_plan import PlanError, plan_of, read_plan
from mbd_study.synthetic import session

PLAN = {"study": "trial", "seed": 3, "conditions": ["mbd", "evidence"], "tasks": ["sorting"], "participants": 2}


@given(st.integers(1, 12))
def test_in_a_williams_design_each_item_is_in_each_place_and_follows_each_other_equally_often(count: int):
    rows = williams_rows(count)
    places = Counter((place, item) for row in rows for place, item in enumerate(row))
    follows = Counter(pair for row in rows for pair in pairwise(row))
    assert all(sorted(row) == list(range(count)) for row in rows)
    assert len(rows) == (count if count % 2 == 0 or count == 1 else 2 * count)
    assert set(places.values()) == {len(rows) // count}
    assert len(places) == count**2
    assert len(follows) == count * (count - 1)
    assert len(set(follows.values())) <= 1


@given(st.sampled_from(Order), st.integers(1, 5), st.integers(1, 4), st.integers(0, 99))
def test_orders_are_balanced_at_each_multiple_and_the_same_for_a_seed(kind: Order, items: int, times: int, seed: int):
    people = times * balanced_at(kind, items)
    rows = orders(kind, items, people, np.random.default_rng(seed))
    assert rows == orders(kind, items, people, np.random.default_rng(seed))
    assert len(rows) == people
    if kind in (Order.WILLIAMS, Order.BLOCKS):
        firsts = Counter(row[0] for row in rows)
        assert len(firsts) == items
        assert len(set(firsts.values())) == 1


@given(st.integers(1, 4), st.integers(1, 4), st.integers(1, 9), st.sampled_from(Order))
def test_each_participant_does_each_task_once_in_each_condition_met(
    conditions: int, tasks: int, people: int, kind: Order
):
    value = PLAN | {
        "conditions": [f"c{k}" for k in range(conditions)],
        "tasks": [f"t{k}" for k in range(tasks)],
        "participants": people,
        "condition_order": kind.value,
    }
    plan = plan_of(value)
    planned = planned_sessions(plan)
    assert planned == planned_sessions(plan)
    met = 1 if kind is Order.BLOCKS else conditions
    assert len(planned) == people * met * tasks == len({p.session for p in planned})
    for participant in plan.participants:
        own = [p for p in planned if p.participant == participant]
        assert [p.position for p in own] == list(range(1, met * tasks + 1))
        assert len({(p.condition, p.task) for p in own}) == met * tasks


def test_numbers_that_leave_an_order_unbalanced_are_stated_with_one_that_does_not():
    plan = plan_of(PLAN | {"participants": 3})
    (sentence,) = imbalances(plan)
    assert "4 would do" in sentence
    assert imbalances(replace(plan, participants=("a", "b", "c", "d"))) == ()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"particpants": 3}, "did you mean 'participants'"),
        ({"condition_order": "wiliams"}, "did you mean 'williams'"),
        ({"task_order": "blocks"}, "list it as a condition"),
        ({"conditions": ["a", "a"]}, "'a' twice"),
        ({"conditions": "mbd"}, "expected a list"),
        ({"participants": ["../p1"]}, "folders are named by it"),
        ({"participants": [1, 2]}, "in quotes"),
        ({"participants": 0}, "1 to 9999"),
        ({"seed": "one"}, "whole number"),
        ({"arguments": {"mdb": []}}, "did you mean 'mbd'"),
        ({"arguments": {"mbd": ["strategy"]}}, "name:=value"),
    ],
)
def test_what_a_plan_does_not_know_is_refused_with_what_was_expected(change: dict[str, object], says: str):
    with pytest.raises(PlanError, match=says):
        plan_of(PLAN | change)


@given(st.sampled_from((Order.WILLIAMS, Order.BLOCKS)), st.integers(1, 3), st.integers(1, 4), st.integers(0, 9))
def test_in_each_condition_each_task_is_equally_often_in_each_place(
    kind: Order, conditions: int, tasks: int, seed: int
):
    people = balanced_at(Order.WILLIAMS, tasks) * balanced_at(kind, conditions)
    value = {"conditions": [f"c{k}" for k in range(conditions)], "tasks": [f"t{k}" for k in range(tasks)]}
    plan = plan_of(PLAN | value | {"condition_order": kind.value, "participants": people, "seed": seed})
    assert imbalances(plan) == ()
    places = Counter((p.condition, p.task, (p.position - 1) % tasks) for p in planned_sessions(plan))
    assert len(places) == conditions * tasks**2
    assert len(set(places.values())) == 1


def test_a_key_given_twice_is_refused(tmp_path: Path):
    (tmp_path / "plan.yaml").write_text("study: x\nseed: 1\nconditions: [a]\ntasks: [t]\nseed: 2\nparticipants: 2\n")
    with pytest.raises(PlanError, match="'seed' is given twice"):
        read_plan(tmp_path / "plan.yaml")


def test_two_sessions_of_one_name_are_refused():
    with pytest.raises(PlanError, match="two sessions"):
        planned_sessions(plan_of(PLAN | {"conditions": ["a", "a_b"], "tasks": ["b_c", "c"]}))


def _held(planned: tuple, *numbers: int) -> list[HeldSession]:
    return [
        HeldSession(planned[k].session, planned[k].participant, planned[k].task, time, Phase.DONE)
        for time, k in enumerate(numbers)
    ]


@given(st.integers(0, 8))
def test_a_plan_kept_so_far_has_no_deviation_and_the_next_is_the_first_left(count: int):
    planned = planned_sessions(plan_of(PLAN | {"tasks": ["sorting", "stacking"]}))
    held = _held(planned, *range(count))
    assert deviations(planned, held, {}) == ()
    assert next_session(planned, held, {}) == (planned[count] if count < 8 else None)


def test_each_way_of_leaving_the_plan_is_a_deviation_that_counts_until_its_reason_is_recorded():
    planned = planned_sessions(plan_of(PLAN | {"tasks": ["sorting", "stacking"]}))
    held = _held(planned, 1, 0, 3)
    held[2] = replace(held[2], task="assembly", phase=Phase.ABORTED)
    held.append(HeldSession("extra", "p09", "sorting", 9, Phase.DONE))
    found = deviations(planned, held, {})
    said = {(d.session, d.what.split()[0]) for d in found}
    names = [p.session for p in planned]
    assert said == {
        (names[0], "held"),
        (names[2], "passed"),
        (names[3], "held"),
        (names[3], "ended"),
        ("extra", "not"),
    }
    assert fidelity(planned, held, found) == pytest.approx(1 / 5)
    reasons = dict.fromkeys((names[0], names[2], names[3], "extra"), "the robot stood still")
    assert fidelity(planned, held, deviations(planned, held, reasons)) == 1.0
    assert next_session(planned, held, reasons) == planned[4]


def test_what_a_bag_states_of_its_deviation_is_recorded_and_names_what_was_passed_over_for_it():
    planned = planned_sessions(plan_of(PLAN | {"tasks": ["sorting", "stacking"]}))
    first, second = planned[0].session, planned[1].session
    held = _held(planned, 1, 0)
    unstated = {d.session for d in deviations(planned, held, {}) if not d.reason}
    assert unstated == {first}
    held[0] = replace(held[0], deviation="the cups were late", instead_of=first)
    found = deviations(planned, held, {})
    assert {d.session for d in found} == {first, second}
    assert all("the cups were late" in d.reason for d in found)
    assert fidelity(planned, held, found) == 1.0
    # A session that ended early, whose operator noted why.
    held[1] = replace(held[1], phase=Phase.ABORTED)
    assert fidelity(planned, held, deviations(planned, held, {})) == 1.0
    held[0] = replace(held[0], deviation="", instead_of="")
    assert fidelity(planned, held, deviations(planned, held, {})) == 0.5
    held[1] = replace(held[1], deviation="the lamp broke")
    assert fidelity(planned, held, deviations(planned, held, {})) == 1.0


def test_a_session_of_another_condition_than_planned_deviates():
    planned = planned_sessions(plan_of(PLAN))
    (held,) = _held(planned, 0)
    assert deviations(planned, [replace(held, condition=planned[0].condition)], {}) == ()
    (found,) = deviations(planned, [replace(held, condition="another")], {})
    assert "condition another" in found.what


def test_a_deviation_is_read_from_the_facts_and_from_the_notes_that_begin_so(tmp_path: Path):
    made = session("p01_mbd_sorting", np.random.default_rng(0)).recorded
    facts = dict(made.facts) | {"plan.deviation": "task is stacking", "plan.condition": "mbd", "plan.instead_of": "x"}
    texts = ("a cup fell", " Deviation:  the lamp  broke")
    notes = tuple(Recorded(text, k, made.states[0].log_time + k) for k, text in enumerate(texts, start=1))
    with BagWriter(tmp_path / "bag") as bag:
        session_to_bag(replace(made, facts=facts, notes=notes), bag)
    (held,), problems = held_sessions(tmp_path)
    assert problems == ()
    assert held.deviation == "task is stacking; the lamp broke"
    assert (held.condition, held.instead_of) == ("mbd", "x")


def run(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["plan", *words])
    with pytest.raises(SystemExit) as ended:
        plan_command.main()
    return int(ended.value.code)


def test_the_command_takes_the_next_session_from_the_bags_and_keeps_reasons(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    plan = tmp_path / "plan.yaml"
    plan.write_text(
        "study: trial\nseed: 3\nconditions: [mbd, evidence]\ntasks: [sorting]\nparticipants: 2\n"
        "arguments:\n  mbd: ['strategy:=mbd']\n"
    )
    planned = planned_sessions(plan_of(PLAN))
    sessions = tmp_path / "sessions"
    sessions.mkdir()
    assert run(monkeypatch, str(plan), "--sessions", str(sessions)) == 0
    assert f"session:={planned[0].session} " in capsys.readouterr().out
    made = session(planned[1].session, np.random.default_rng(0)).recorded
    with BagWriter(sessions / planned[1].session) as bag:
        session_to_bag(replace(made, facts=dict(made.facts) | {"participant": "p01"}), bag)
    assert run(monkeypatch, str(plan), "--sessions", str(sessions)) == plan_command.UNRECORDED
    assert f"{planned[0].session}: passed over" in capsys.readouterr().out
    words = (str(plan), "--sessions", str(sessions), "--record", planned[0].session, "the lamp broke")
    assert run(monkeypatch, *words) == 0
    out = capsys.readouterr().out
    assert "recorded: the lamp broke" in out
    assert "100 % of the sessions" in out
    assert f"next: {planned[2].session}" in out
    assert run(monkeypatch, str(plan), "--out", str(plan)) == 2
    assert run(monkeypatch, str(tmp_path)) == 2
    assert "cannot be read" in " ".join(capsys.readouterr().err.split())
