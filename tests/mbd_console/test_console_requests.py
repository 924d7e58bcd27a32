"""Whatever a browser sends becomes a request that makes sense or a sentence of refusal, never anything else."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console.actions import Action
from mbd_console.requests import (
    NOTE_LENGTH,
    AnswerQuestion,
    Overwrite,
    PointAtPlace,
    Press,
    RequestRefusedError,
    WriteNote,
    next_meant_step,
    read_request,
)
from mbd_console.state import ConsoleState
from mbd_interaction.synthetic import row_of_objects, stacking_task
from mbd_model.assists import Assist
from mbd_model.camera.view import CameraView
from mbd_model.objects import Role
from mbd_model.session import Awaited, Phase, SessionState

VIEW = CameraView.from_parameters((600, 600, 320, 240), (640, 480), (0.6, 0.0, 1.2), (-0.70710678, 0.70710678, 0, 0))
TARGETS = ("t1", "t2", "t3", "t4")


def in_assist_phase(step: int = 0, *, phase: Phase = Phase.ASSIST, assists: tuple[Assist, ...] = ()) -> ConsoleState:
    """Step 0 is a PICK, step 1 a PLACE."""
    return ConsoleState(
        session=SessionState("s", phase, step_index=step, assists=assists),
        task=stacking_task(4),
        target=row_of_objects(Role.TARGET, "t", 4),
        planes=((Role.TARGET, (0.0, 0.0, 1.0, 0.0)),),
        question=7,
        view=VIEW,
    )


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)
FIELDS = ("action", "object_id", "number", "question", "u", "v", "text", "step")
RAW = st.fixed_dictionaries(
    {"action": st.sampled_from([*Action, "object", "place", "escape", "key", "shutdown"]) | JSON},
    optional={name: JSON | st.sampled_from([7, "t1", "1", 100.0]) for name in FIELDS[1:]},
)


@given(raw=RAW | JSON, step=st.sampled_from([-1, 0, 1]), phase=st.sampled_from(Phase), meant=st.sampled_from([-1, 0]))
def test_anything_at_all_is_taken_or_refused_with_a_reason(raw: object, step: int, phase: Phase, meant: int):
    state = in_assist_phase(step, phase=phase)
    try:
        request = read_request(raw, state, meant)
    except RequestRefusedError as refusal:
        assert len(str(refusal)) > 10
        return
    if isinstance(request, AnswerQuestion | Overwrite):
        assert request.object_id in TARGETS
    if isinstance(request, WriteNote):
        assert 0 < len(request.text) <= NOTE_LENGTH
        assert request.text.isprintable()


@given(raw=RAW | JSON, phase=st.sampled_from(Phase))
def test_anything_at_all_chooses_a_assisted_step_or_is_refused(raw: object, phase: Phase):
    state = in_assist_phase(-1, phase=phase, assists=(Assist("s1", "t1", 0), Assist("s2", "t2", 1)))
    try:
        step = next_meant_step(raw, state, -1)
    except RequestRefusedError as refusal:
        assert str(refusal)
    else:
        assert step == 1 or (isinstance(raw, dict) and raw["step"] == step)


@pytest.mark.parametrize("sent", [{"object_id": "t3"}, {"number": "3"}])
def test_an_object_answers_what_is_asked_handed_for_a_pick_and_pointed_at_for_a_place(sent: dict[str, str]):
    raw = {"action": "object", "question": 7, **sent}
    assert read_request(raw, in_assist_phase(0)) == AnswerQuestion("t3", pointed=False)
    assert read_request(raw, in_assist_phase(1)) == AnswerQuestion("t3", pointed=True)


def test_an_answer_to_a_question_that_is_no_longer_asked_is_refused():
    with pytest.raises(RequestRefusedError, match="something else by now"):
        read_request({"action": "object", "object_id": "t3", "question": 6}, in_assist_phase())


def test_after_i_meant_an_object_overwrites_even_when_nothing_is_asked():
    state = in_assist_phase(-1, phase=Phase.EXECUTE)
    assert read_request({"action": "object", "object_id": "t2", "question": 0}, state, 0) == Overwrite(0, "t2")


def test_i_meant_goes_back_through_the_assisted_steps_and_then_lets_go():
    state = in_assist_phase(4, assists=(Assist("s1", "t1", 0), Assist("s2", "t2", 1)))
    chosen = [-1]
    for _ in range(3):
        chosen.append(next_meant_step({}, state, chosen[-1]))
    assert chosen == [-1, 1, 0, -1]
    assert next_meant_step({"step": 0}, state, -1) == 0
    assert next_meant_step({"step": 0}, state, 0) == -1


def test_a_place_pointed_at_is_the_point_of_the_table_under_the_pixel():
    place = (0.5, 0.1, 0.0)
    ((u, v),) = VIEW.project([place])
    request = read_request({"action": "place", "u": float(u), "v": float(v), "question": 7}, in_assist_phase(1))
    assert isinstance(request, PointAtPlace)
    assert request.place == pytest.approx(place, abs=1e-9)


def test_a_place_is_no_answer_to_what_do_i_use():
    with pytest.raises(RequestRefusedError, match="for an object"):
        read_request({"action": "place", "u": 1.0, "v": 1.0, "question": 7}, in_assist_phase(0))


def test_a_paused_session_takes_no_answer():
    state = in_assist_phase()
    state = dataclasses.replace(state, session=dataclasses.replace(state.session, paused=True))
    with pytest.raises(RequestRefusedError, match="paused"):
        read_request({"action": "object", "object_id": "t1", "question": 7}, state)
    assert read_request({"action": "pause"}, state) == Press(Action.PAUSE)


def test_a_note_keeps_its_words_and_loses_what_would_break_a_line():
    assert read_request({"action": "note", "text": " a\nb\x00\u202e c  "}, ConsoleState()) == WriteNote("a b c")


@pytest.mark.parametrize("text", ["", "  \n", "x" * (NOTE_LENGTH + 1), None, 3])
def test_an_empty_too_long_or_wordless_note_is_refused(text: object):
    with pytest.raises(RequestRefusedError):
        read_request({"action": "note", "text": text}, ConsoleState())


def test_before_the_dialogue_was_received_only_gripper_and_notes_go_out():
    for action in set(Action) - {Action.OPEN, Action.CLOSE, Action.NOTE, Action.MEANT}:
        with pytest.raises(RequestRefusedError, match="interaction node"):
            read_request({"action": action}, ConsoleState())


@pytest.mark.parametrize(
    ("awaiting", "taken"),
    [
        (Awaited.CONFIRMATION, {Action.YES, Action.NO}),
        (Awaited.YES_OR_NO, {Action.YES, Action.NO}),
        (Awaited.ONE_OF_TWO, {Action.NO}),
        (Awaited.HANDED, set()),
        (Awaited.ESTIMATE, set()),
    ],
)
def test_yes_and_no_are_offered_to_the_questions_that_take_them(awaiting: Awaited, taken: set[Action]):
    state = in_assist_phase()
    assert state.session is not None
    asked = dataclasses.replace(state, session=dataclasses.replace(state.session, awaiting=awaiting))
    for action in (Action.YES, Action.NO):
        if action in taken:
            assert read_request({"action": action, "question": 7}, asked) == Press(action)
        else:
            with pytest.raises(RequestRefusedError, match="is not possible just now"):
                read_request({"action": action, "question": 7}, asked)


def test_a_yes_to_a_question_that_is_no_longer_asked_is_refused():
    state = in_assist_phase()
    assert state.session is not None
    asked = dataclasses.replace(state, session=dataclasses.replace(state.session, awaiting=Awaited.CONFIRMATION))
    with pytest.raises(RequestRefusedError, match="asks something else by now"):
        read_request({"action": "yes", "question": 6}, asked)


@given(
    action=st.sampled_from(sorted(set(Action) - {Action.MEANT, Action.NOTE})),
    phase=st.sampled_from(Phase),
    step=st.sampled_from([-1, 0, 1]),
)
def test_why_something_is_not_possible_is_a_reason_and_not_what_the_robot_just_said(
    action: Action, phase: Phase, step: int
):
    state = in_assist_phase(step, phase=phase)
    assert state.session is not None
    asking = dataclasses.replace(state, session=dataclasses.replace(state.session, detail="What do I use now?"))
    try:
        read_request({"action": action, "question": 7}, asking)
    except RequestRefusedError as refusal:
        assert "What do I use now?" not in str(refusal)
        assert len(str(refusal).partition("just now: ")[2].split()) > 4
