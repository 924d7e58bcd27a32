"""``session`` takes every argument of the launch file, by either spelling, and the next session from a study's plan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.ros.session_conversions import session_to_bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bringup.launch_arguments import ARGUMENTS, options_of
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.planned_words import planned_words
from mbd_bringup.ros.known_tasks import refuse_unknown_task
from mbd_bringup.ros.lead_session import LedSession, lead_in_turn
from mbd_bringup.session_words import all_words, given_words, words_of_next
from mbd_model.errors import MbdError
from mbd_model.session import Phase
from mbd_study.plan.schedule import planned_sessions
from mbd_study.plan.study_plan import read_plan
from mbd_study.synthetic import session
from rich.console import Console

PLAN = """study: trial
seed: 3
conditions: [mbd, evidence]
tasks: [sorting, stacking]
participants: 2
arguments:
  mbd: ['strategy:=mbd', 'threshold:=0.02']
"""
TEXTS = {"session": "p7", "task": "stacking", "participant": "p07", "seed": "3", "robot": "ur5e", "port": "8081"}
FLAGS = ("console", "execute", "simulated", "scripted_wizard", "markers", "resume")


@given(st.dictionaries(st.sampled_from([*TEXTS, *FLAGS]), st.booleans()))
def test_an_option_and_a_word_of_the_launch_file_mean_the_same(chosen: dict[str, bool]):
    words = [f"{n}:={TEXTS.get(n, str(on).lower())}" for n, on in chosen.items()]
    options = []
    for name, on in chosen.items():
        flag = name.replace("_", "-")
        options += [f"--{flag}", TEXTS[name]] if name in TEXTS else [f"--{flag}" if on else f"--no-{flag}"]
    assert given_words(words) == given_words(options)


def options(*words: str) -> SessionOptions:
    found = given_words(words)
    return options_of(all_words(found), found)


def test_every_argument_of_the_launch_file_has_its_option(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as ended:
        given_words(["--help"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert all(f"--{name.replace('_', '-')}" in said for name in ARGUMENTS)


def test_with_a_console_a_person_leads_whom_the_teacher_gives_time(tmp_path: Path):
    folder = f"folder:={tmp_path}"
    led = options("--task", "sorting", "--participant", "p01", "--console", folder)
    assert led.led_by_person
    assert (led.session, led.folder) == ("p01_sorting", tmp_path / "p01_sorting")
    nodes = {n.executable: n.parameters for n in session_nodes(led)}
    assert "wizard" not in nodes
    assert nodes["console"]["port"] == 8080
    assert nodes["cell"]["reminder"] >= 15.0
    assert nodes["recorder"]["end_with_session"] is True
    assert not options(folder).led_by_person
    assert not options("--console", "--scripted-wizard", folder).led_by_person
    assert options("--no-simulated", folder).led_by_person


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["task"], "'task' is no name:=value"),
        (["sede:=3"], "no launch argument 'sede'; did you mean 'seed'"),
        (["seed:=3", "--seed", "4"], "seed is given twice"),
        (["port:=abc"], "port:=abc is not an integer"),
        (["--port", "70000"], "port 70000 is not in 1..65535"),
        (["--deviation", "late"], "give the plan too"),
        (["--plan", "/no/such.yaml"], "cannot be read"),
        (["--camera", "kinekt"], "kinekt"),
        (["--forms", "nasa_tlx@lunch"], "there is no phase 'lunch'"),
        (["forms:=nasa"], "there is no form 'nasa'"),
        (["--language", "fr"], "language 'fr' is none of en, de"),
    ],
)
def test_a_mistake_is_said_before_anything_starts(words: list[str], why: str):
    with pytest.raises(MbdError, match=why):
        options(*words)


@pytest.fixture
def study(tmp_path: Path) -> tuple[Path, list[str]]:
    """A plan, and the words that take a session of it."""
    (tmp_path / "plan.yaml").write_text(PLAN)
    (tmp_path / "sessions").mkdir()
    return tmp_path, ["--plan", str(tmp_path / "plan.yaml"), "--folder", str(tmp_path / "sessions")]


def hold(folder: Path, made: SessionOptions) -> None:
    """A bag of that session, done, as its recorder leaves it."""
    recorded = session(made.session, np.random.default_rng(0)).recorded
    facts = {"session": made.session, "participant": made.participant, "task": made.task}
    facts |= {f"plan.{name}": value for name, _, value in (fact.partition("=") for fact in made.plan)}
    with BagWriter(folder / "sessions" / made.session / "bag") as bag:
        session_to_bag(replace(recorded, facts=dict(recorded.facts) | facts), bag)


def test_the_plan_gives_session_participant_task_seed_and_the_condition_s_arguments(study: tuple[Path, list[str]]):
    folder, words = study
    planned = planned_sessions(read_plan(folder / "plan.yaml"))
    for one in planned:
        made = options(*words)
        assert (made.session, made.participant, made.task, made.seed) == (
            one.session, one.participant, one.task, one.seed
        )  # fmt: skip
        assert (made.strategy, made.threshold) == (("mbd", 0.02) if one.condition == "mbd" else ("evidence", None))
        assert f"condition={one.condition}" in made.plan
        assert not [fact for fact in made.plan if fact.startswith("deviation")]
        hold(folder, made)
    with pytest.raises(MbdError, match="was held or given up: nothing is next"):
        options(*words)


def test_what_is_asked_for_against_the_plan_is_done_and_its_bag_states_it(study: tuple[Path, list[str]]):
    folder, words = study
    usual = options(*words)
    other = "stacking" if usual.task == "sorting" else "sorting"
    made = options(*words, "--task", other, "--deviation", "the cups were late")
    assert (made.task, made.participant) == (other, usual.participant)
    facts = dict(fact.split("=", 1) for fact in made.plan)
    assert facts["deviation"] == f"held when {usual.session} was next: the cups were late"
    assert facts["instead_of"] == usual.session
    hold(folder, made)
    assert options(*words).session == usual.session
    strategy = "evidence" if usual.strategy == "mbd" else "mbd"
    if usual.strategy == "mbd":
        facts = dict(fact.split("=", 1) for fact in options(*words, f"strategy:={strategy}").plan)
        assert facts["deviation"] == "strategy is evidence, planned was mbd"
    facts = dict(fact.split("=", 1) for fact in options(*words, "session:=extra").plan)
    assert facts["deviation"].endswith("not planned")


def test_a_participant_whom_the_plan_has_not_is_said_to_be_none_and_not_to_be_done(study: tuple[Path, list[str]]):
    with pytest.raises(MbdError, match=r"has no participant 'p99'; (did you mean|it has) "):
        options(*study[1], "--participant", "p99")


@pytest.mark.parametrize(
    ("wrong", "meant"), [("--taks", "--task"), ("--out", "--folder"), ("--no-consle", "--no-console")]
)
def test_an_option_there_is_not_is_one_line_that_names_the_one_meant(
    wrong: str, meant: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as ended:
        given_words([wrong, "x"])
    said = capsys.readouterr().err
    assert (ended.value.code, said.count("\n")) == (2, 1)
    assert f"there is no option {wrong}; did you mean {meant}?" in said


def test_a_task_that_the_simulated_cell_has_not_is_refused_before_anything_starts(tmp_path: Path):
    folder = f"folder:={tmp_path}"
    with pytest.raises(MbdError, match="no task 'sort'; did you mean 'sorting'"):
        refuse_unknown_task(options("--task", "sort", folder))
    refuse_unknown_task(options("--task", "sort", "--no-simulated", folder))
    refuse_unknown_task(options("--task", "assembly", folder))


def test_another_participant_than_the_first_left_is_no_deviation(study: tuple[Path, list[str]]):
    _, words = study
    made = options(*words, "--participant", "p02")
    assert made.participant == "p02"
    assert not [fact for fact in made.plan if fact.startswith("deviation")]


def test_what_comes_next_keeps_the_equipment_and_forgets_what_named_the_session(study: tuple[Path, list[str]]):
    _, words = study
    found = given_words([*words, "--participant", "p02", "--console", "--robot", "ur5e", "--seed", "7"])
    after = words_of_next(found)
    assert set(after) == {"plan", "folder", "console", "robot"}
    assert planned_words(all_words(after), after).planned.participant == "p01"


def test_each_press_for_the_next_participant_starts_what_the_plan_has_next(study: tuple[Path, list[str]]):
    """From a first session that another participant held, with another seed, to the last of the plan."""
    folder, words = study
    held: list[SessionOptions] = []

    class HeldSession(LedSession):
        """No node is started: the session leaves its bag, and its operator presses for the next while there is one."""

        def lead(self) -> tuple[Phase | None, bool]:
            hold(folder, self.options)
            held.append(self.options)
            return Phase.DONE, len(held) < len(planned)

    planned = planned_sessions(read_plan(folder / "plan.yaml"))
    first = next(one for one in planned if one.participant == "p02")
    begun = given_words([*words, "--participant", "p02", "--seed", "77", "--deviation", "p02 came first"])
    assert lead_in_turn(begun, Console(quiet=True), HeldSession) is Phase.DONE
    assert (held[0].session, held[0].seed) == (first.session, 77)
    assert "deviation=seed is 77" in " ".join(held[0].plan)
    after = [(o.session, o.participant, o.task, o.seed) for o in held[1:]]
    assert after == [(p.session, p.participant, p.task, p.seed) for p in planned if p is not first]
    for one in held:
        condition = "mbd" if "condition=mbd" in one.plan else "evidence"
        assert (one.strategy, one.threshold) == (("mbd", 0.02) if condition == "mbd" else ("evidence", None))
    assert not [fact for one in held[1:] for fact in one.plan if fact.startswith("deviation")]
