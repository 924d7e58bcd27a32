"""What the page of steps shows of a task, and which corrections it offers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console import state as console_state
from mbd_console.actions import Action, offered
from mbd_console.requests import AnswerQuestion, CorrectStep, RequestRefusedError, read_request
from mbd_console.state import ConsoleState
from mbd_console.steps.moments import KEPT, PERIOD, MomentPictures
from mbd_console.steps.rows import CarryRow, corrected_now, rows
from mbd_console.words.texts import PageTexts
from mbd_demonstration.revision.corrections import corrected
from mbd_demonstration.segmentation import segment
from mbd_demonstration.synthetic import Sensing, demonstrate, random_moves, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_interaction.synthetic import doubtful_task, stacking_task
from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep
from mbd_model.task_words import carries, names_in


def offers(row: CarryRow) -> list[StepCorrection]:
    """Every correction a row offers."""
    plain = [c for c in (row.earlier, row.later, row.join, row.delete) if c is not None]
    changes = [c.change(i) for c in row.choices for i, _ in c.options if i != c.present]
    split = [row.split_at((row.split[0] + row.split[1]) / 2)] if row.split else []
    return [*plain, *changes, *split]


@given(seed=st.integers(0, 2**32))
def test_every_correction_that_is_offered_can_be_made_and_keeps_a_task_that_can_be_shown(seed: int):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 4)
    made = demonstrate(scene, random_moves(rng, scene, 3), Sensing(), rng)
    path = ToolTrajectory.from_samples(made.stamps, made.positions, made.quaternions)
    task = segment(path, made.events, scene, stamp=1.0)
    for row in rows(task):
        for correction in offers(row):
            after = corrected(task, correction, 2.0, path)
            assert after.steps != task.steps
            assert [s for r in carries(after.steps) for s in r.steps] == list(after.steps)
            assert len(rows(after)) == len(carries(after.steps))


@given(seed=st.integers(0, 2**32))
def test_what_is_moved_earlier_and_then_later_is_where_it_was(seed: int):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 4)
    made = demonstrate(scene, random_moves(rng, scene, 3), Sensing(), rng)
    path = ToolTrajectory.from_samples(made.stamps, made.positions, made.quaternions)
    task = segment(path, made.events, scene, stamp=1.0)
    for k, row in enumerate(rows(task)):
        if row.earlier is not None:
            there = corrected(task, row.earlier, 2.0, None)
            back = rows(there)[k - 1].later
            assert back is not None and corrected(there, back, 3.0, None).steps == task.steps


def scene_of(*words: tuple[str, str]) -> Scene:
    things = [
        SceneObject(f"s{k}", (0.5, 0.2 * k, 0.05), (0.06, 0.06, 0.1), color_name=color, object_class=kind)
        for k, (color, kind) in enumerate(words, start=1)
    ]
    return Scene(Role.SOURCE, tuple(things))


def step(index: int, kind: StepKind, about: str) -> TaskStep:
    return TaskStep(index, kind, about, 0.0)


def test_a_carry_is_a_sentence_whatever_it_lacks():
    scene = scene_of(("red", "bowl"), ("", "plate"), ("red", "bowl"), ("", "unknown"))
    pick, place = StepKind.PICK, StepKind.PLACE
    steps = (step(0, pick, "s1"), step(1, place, "s2"), step(2, pick, "s2"), step(3, place, "s2"), step(4, place, "s4"))
    task = Task(scene, (*steps, step(5, pick, "s3")))
    assert [row.sentence for row in rows(task)] == [
        "Pick the red bowl s1, put it onto the plate.",
        "Pick the plate, put it down.",
        "Put what is held onto the object s4.",
        "Pick the red bowl s3 (it is still held).",
    ]
    assert [row.sentence for row in rows(task, PageTexts("de"))] == [
        "Die rote Schüssel s1 nehmen, auf den Teller legen.",
        "Den Teller nehmen und wieder hinlegen.",
        "Was gehalten wird, auf das Objekt s4 legen.",
        "Die rote Schüssel s3 nehmen (ist noch in der Hand).",
    ]
    assert len(set(names_in(scene).values())) == 4


def asked(**session: object) -> ConsoleState:
    state = ConsoleState(session=SessionState("s", Phase.TUCK_AND_CLEAR, step_index=0, **session), phase_began=0.0)
    prompt = Prompt(PromptKind.WHICH_WAS_MEANT, "Did you?", 0, "s1", source_ids=("s1", "s2"))
    return console_state.on_prompt(console_state.on_task(state, doubtful_task(4, 0)), prompt, 1.0)


def test_which_was_meant_is_answered_by_number_and_by_id_and_nothing_else():
    state = asked()
    for raw, meant in (({"number": "1"}, "s1"), ({"number": "2"}, "s2"), ({"object_id": "s2"}, "s2")):
        assert read_request({"action": "object", "question": 1, **raw}, state) == AnswerQuestion(meant, pointed=True)
    for raw in ({"number": "3"}, {"number": "²"}, {"object_id": "s3"}, {"object_id": None}, {}):
        with pytest.raises(RequestRefusedError, match="choose s1 or s2"):
            read_request({"action": "object", "question": 1, **raw}, state)
    with pytest.raises(RequestRefusedError, match="something else by now"):
        read_request({"action": "object", "question": 0, "number": "1"}, state)
    with pytest.raises(RequestRefusedError, match="paused"):
        read_request({"action": "object", "question": 1, "number": "1"}, asked(paused=True))
    assert offered(state, Action.SKIP)
    silent = console_state.on_prompt(state, Prompt(PromptKind.INFORM, "So be it."), 2.0)
    assert not offered(silent, Action.SKIP) and silent.candidates == ()


def test_the_last_step_is_deleted_and_recorded_again_by_the_same_topic():
    state = console_state.on_task(asked(), stacking_task(3))
    for action, kind in (
        (Action.DELETE_LAST_STEP, CorrectionKind.DELETE),
        (Action.RERECORD_STEP, CorrectionKind.RERECORD),
    ):
        assert read_request({"action": action}, state) == CorrectStep(StepCorrection(kind, 3))


def test_nothing_is_corrected_while_recording_paused_or_once_the_robot_goes_on():
    session = SessionState("s", Phase.TUCK_AND_CLEAR)
    assert corrected_now(ConsoleState(session=session)) == ""
    assert "being recorded" in corrected_now(ConsoleState(session=replace(session, recording=True)))
    assert "paused" in corrected_now(ConsoleState(session=replace(session, paused=True)))
    for phase in (Phase.OBSERVE_SOURCE, Phase.EXECUTE, Phase.DONE, Phase.ABORTED):
        assert corrected_now(ConsoleState(session=replace(session, phase=phase)))
    assert corrected_now(ConsoleState())


def gray(value: int) -> np.ndarray:
    return np.full((48, 64, 3), value, np.uint8)


def test_the_picture_of_a_moment_is_the_nearest_one_and_none_where_none_is_near():
    pictures = MomentPictures()
    for k in range(40):
        pictures.add(10.0 + 0.1 * k, gray(k))
    assert pictures.jpeg(8.0) is None and pictures.jpeg(15.5) is None
    assert pictures.jpeg(9.5) == pictures.jpeg(10.0) != pictures.jpeg(12.0)
    assert pictures.jpeg(12.02) == pictures.jpeg(12.0)


def test_pictures_of_steps_outlive_ten_minutes_and_a_clock_set_back():
    pictures = MomentPictures()
    pictures.add(5.0, gray(200))
    first = pictures.jpeg(5.0)
    pictures.keep([5.0, 500.0])
    for k in range(KEPT + 10):
        pictures.add(6.0 + PERIOD * k, gray(0))
    assert pictures.jpeg(5.0) == first and pictures.jpeg(6.0) is None
    pictures.add(1.0, gray(100))
    assert pictures.jpeg(5.0) == first and pictures.jpeg(100.0) is None
    pictures.keep([])
    assert pictures.jpeg(5.0) is None
