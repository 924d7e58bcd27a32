"""A rehearsed study keeps its plan or states where not, and its people err as often as they are asked to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import read_metadata
from mbd_experiments.rehearsal.answered_forms import due_forms, filled_by_chance
from mbd_experiments.rehearsal.holding import SlipRates, held_plan
from mbd_experiments.rehearsal.rehearsal_page import RehearsedRow, rehearsal_page
from mbd_experiments.rehearsal.rehearsal_tasks import rehearsal_tasks
from mbd_experiments.rehearsal.rehearse_command import PLAN
from mbd_experiments.rehearsal.rehearsed_session import hold
from mbd_experiments.simulated_participants.study import Finished
from mbd_model.errors import MbdError
from mbd_model.forms.form import ItemKind
from mbd_model.forms.reading import read_form, shipped_forms
from mbd_model.session import Phase
from mbd_model.share_folder import config_folder
from mbd_study.plan.protocol import HeldSession, deviations, fidelity, held_sessions
from mbd_study.plan.schedule import planned_sessions
from mbd_study.plan.study_plan import StudyPlan, plan_of, read_plan


def study(tmp_path: Path, participants: int = 2) -> StudyPlan:
    path = tmp_path / "plan.yaml"
    path.write_text(PLAN.format(seed=1, participants=participants))
    return read_plan(path)


PEOPLE = plan_of(
    {"study": "s", "seed": 1, "conditions": ["a", "b"], "tasks": ["stacking", "sorting"], "participants": 6}
)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.integers(0, 999))
def test_whatever_order_sessions_are_held_in_each_is_held_once_and_every_deviation_is_stated(
    order: float, ended: float, seed: int
):
    planned = planned_sessions(PEOPLE)
    made = held_plan(planned, SlipRates(order=order, ended=ended), seed)
    assert made == held_plan(planned, SlipRates(order=order, ended=ended), seed)
    assert sorted(h.planned.session for h in made) == sorted(p.session for p in planned)
    held = [
        HeldSession(
            h.planned.session,
            h.planned.participant,
            h.planned.task,
            h.begun,
            Phase.ABORTED if h.ended_early else Phase.DONE,
            h.planned.condition,
            "; ".join(filter(None, (h.deviation, "the participant wanted to stop" if h.ended_early else ""))),
            h.instead_of,
        )
        for h in made
    ]
    found = deviations(planned, held, {})
    assert fidelity(planned, held, found) == 1.0
    silent = [replace(h, deviation="", instead_of="") for h in held]
    left = deviations(planned, silent, {})
    assert bool(left) == any(h.deviation or h.ended_early for h in made)
    assert (fidelity(planned, silent, left) == 1.0) == (not left)


@pytest.mark.parametrize("name", shipped_forms())
def test_every_shipped_form_is_filled_in_completely_and_within_its_items(name: str):
    form = read_form(name)
    for seed in range(20):
        sent = filled_by_chance(form, seed / 19, np.random.default_rng(seed))
        assert all(a.answered for a in sent.answers)
        for item, answer in zip(form.items, sent.answers, strict=True):
            if item.kind is ItemKind.SCALE:
                assert answer.number in item.scale.values


def test_consent_comes_first_and_the_robot_is_judged_at_the_end_of_a_condition():
    forms = {name: read_form(name) for name in ("consent", "demographics", "nasa_tlx", "godspeed")}
    assert [f.name for f in due_forms(forms, first=True, last=False)] == ["consent", "demographics", "nasa_tlx"]
    assert [f.name for f in due_forms(forms, first=False, last=True)] == ["nasa_tlx", "godspeed"]


def test_two_participants_meet_each_condition_with_each_task_and_its_arguments(tmp_path: Path):
    tasks = rehearsal_tasks(study(tmp_path), SlipRates(), 1)
    assert len(tasks) == 2 * 2 * 3
    assert {(t.held.planned.condition, t.parameters["strategy"]) for t in tasks} == {
        ("mbd", "mbd"),
        ("evidence", "evidence"),
    }
    assert sum(t.first for t in tasks) == 2
    assert sum(t.last for t in tasks) == 4
    assert all(t.intention.task == t.held.planned.task for t in tasks)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"tasks": ["juggling"]}, "'juggling'.* cannot be rehearsed"),
        ({"arguments": {"a": ["robot:=ur5e"]}}, "argument 'robot' cannot be rehearsed"),
        ({"arguments": {"a": ["threshold:=high"]}}, "threshold:=high is not a number"),
        ({"arguments": {"a": ["strategy:=best"]}}, "strategy is 'best'"),
    ],
)
def test_what_cannot_be_rehearsed_is_said_before_a_session_is_held(change: dict, why: str):
    plan = {"study": "s", "seed": 1, "conditions": ["a"], "tasks": ["sorting"], "participants": 1}
    with pytest.raises(MbdError, match=why):
        rehearsal_tasks(plan_of(plan | change), SlipRates(), 1)


def test_a_rate_that_is_no_share_is_refused():
    with pytest.raises(MbdError, match="the rate click is 5"):
        SlipRates(click=5.0)


def test_the_page_names_every_session_and_says_that_nobody_took_part(tmp_path: Path):
    rows = [RehearsedRow("p01_a_<b>", "p01", "a", "sorting", "done", "it rained", None)]
    page = rehearsal_page("Study s", [("sessions", "1 of 2")], rows, tmp_path, "a < b")
    assert "p01_a_&lt;b&gt;" in page
    assert "it rained" in page
    assert "simulated" in page
    assert "http" not in page


@pytest.mark.system
def test_a_session_that_the_participant_breaks_off_has_its_forms_its_slips_and_its_reason_in_its_bag(tmp_path: Path):
    """One session, wholly: rendered, perceived, demonstrated, asked about; every click of the operator's goes wrong."""
    plan = study(tmp_path)
    task = rehearsal_tasks(plan, SlipRates(click=1.0, noticed=1.0, order=0.0, ended=1.0), 1)[0]
    sessions = tmp_path / "sessions"
    knowledge = config_folder("mbd_perception") / "knowledge.yaml"
    done = hold(task, sessions, config_folder("mbd_cell"), knowledge)
    assert isinstance(done, Finished), done
    bag = Bag(done.bag)
    assert [msg.form for _, msg in bag.decoded({"/study/form"})] == ["consent", "demographics"]
    assert int(read_metadata(done.bag)["custom_data"]["operator.wrong_buttons"]) > 0
    (held,), problems = held_sessions(sessions)
    assert problems == ()
    assert (held.phase, held.condition) == (Phase.ABORTED, task.held.planned.condition)
    assert held.deviation == "the participant wanted to stop"
    found = deviations(planned_sessions(plan), [held], {})
    assert [(d.session, bool(d.reason)) for d in found] == [(task.name, True)]
