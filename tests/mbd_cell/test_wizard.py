"""The scripted wizard sends what an operator would, once, and the right thing."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_cell.teacher.recognition import TrueTable, recognise, right_target
from mbd_cell.teacher.script import Word
from mbd_cell.teacher.wizard import Wizard, WizardAct
from mbd_model.assists import Assist
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from rewording import REWORDINGS, Rewording, reworded

SOURCE = TrueTable({"cup_a": (0.3, 0.2), "cup_b": (0.5, 0.0)}, {})
TARGET = TrueTable({"bowl_a": (0.4, -0.2), "bowl_b": (0.3, 0.3)}, {"cup_a": ["bowl_a"], "cup_b": ["bowl_b", "bowl_a"]})


def seen(role: Role, places: dict[str, tuple[float, float]], off: float = 0.004) -> Scene:
    """A perceived scene of those true places under ids of its own."""
    prefix = role.value[0]
    return Scene(
        role,
        tuple(
            SceneObject(f"{prefix}{k}", (x + off, y - off, 0.04), (0.05, 0.05, 0.06))
            for k, (x, y) in enumerate(places.values())
        ),
    )


def knowing_wizard(phase: Phase, wrong_step: int = -1, assists: tuple[Assist, ...] = ()) -> Wizard:
    wizard = Wizard(wrong_step=wrong_step)
    wizard.tables = {Role.SOURCE: SOURCE, Role.TARGET: TARGET}
    wizard.scenes = {
        Role.SOURCE: seen(Role.SOURCE, dict(SOURCE.places)),
        Role.TARGET: seen(Role.TARGET, dict(TARGET.places)),
    }
    wizard.see_state(SessionState("x", phase, assists=assists))
    return wizard


def ask(step: int, source_id: str, kind: PromptKind = PromptKind.WHAT_DO_I_USE) -> Prompt:
    return Prompt(kind, "?", step, source_id)


@pytest.mark.parametrize(
    ("word", "phase", "act"),
    [
        (Word.OPEN, Phase.DEMONSTRATE, WizardAct.OPEN),
        (Word.CLOSE, Phase.DEMONSTRATE, WizardAct.CLOSE),
        (Word.DEMONSTRATION_BEGINS, Phase.DEMONSTRATE, WizardAct.START),
        (Word.DEMONSTRATION_ENDS, Phase.DEMONSTRATE, WizardAct.STOP),
        (Word.READY, Phase.OBSERVE_SOURCE, WizardAct.NEXT_PHASE),
        (Word.READY, Phase.TUCK_AND_CLEAR, WizardAct.NEXT_PHASE),
    ],
)
def test_each_word_of_the_teacher_becomes_one_event(word: Word, phase: Phase, act: WizardAct) -> None:
    wizard = knowing_wizard(phase)
    wizard.on_word(word)
    request = wizard.next_request(0.0, replies=False)
    assert request is not None and request.act is act
    assert wizard.next_request(100.0, replies=False) is None


def test_without_anything_to_do_nothing_is_sent() -> None:
    assert Wizard().next_request(0.0, replies=True) is None
    assert knowing_wizard(Phase.DONE).next_request(0.0, replies=True) is None


def test_nothing_is_sent_twice_while_the_reply_is_awaited() -> None:
    wizard = knowing_wizard(Phase.OBSERVE_TARGET)
    assert wizard.next_request(0.0, replies=True) is not None
    assert all(wizard.next_request(0.1 * k, replies=True) is None for k in range(100))


def test_a_refused_event_is_tried_again_after_ever_longer_pauses() -> None:
    wizard = knowing_wizard(Phase.OBSERVE_TARGET)
    now, pauses = 0.0, []
    for _ in range(4):
        asked = now
        while wizard.next_request(now, replies=True) is None:
            now += 0.1
        pauses.append(now - asked)
        assert wizard.reply("/wizard/command", False, now) is not None
    assert pauses[0] == 0.0
    assert pauses[1] < pauses[2] < pauses[3]


def test_an_accepted_event_is_not_sent_again_in_the_same_state() -> None:
    wizard = knowing_wizard(Phase.EXECUTE)
    assert wizard.next_request(0.0, replies=True) is not None
    wizard.reply("wizard/command", True, 0.1)
    assert wizard.next_request(50.0, replies=True) is None


def test_a_reply_on_another_topic_is_not_for_the_event_that_waits() -> None:
    wizard = knowing_wizard(Phase.OBSERVE_TARGET)
    wizard.next_request(0.0, replies=True)
    assert wizard.reply("wizard/note", True, 0.1) is None
    assert wizard.next_request(1.0, replies=True) is None


def test_a_lost_event_is_sent_again_after_the_timeout() -> None:
    wizard = knowing_wizard(Phase.OBSERVE_TARGET)
    assert wizard.next_request(0.0, replies=True) is not None
    assert wizard.next_request(wizard.reply_timeout + 0.1, replies=True) is not None


def test_a_demonstration_that_cannot_be_recorded_is_shown_once_more() -> None:
    wizard = knowing_wizard(Phase.DEMONSTRATE)
    wizard.on_word(Word.DEMONSTRATION_ENDS)
    acts, now = [], 0.0
    for _ in range(3):
        while (request := wizard.next_request(now, replies=True)) is None:
            now += 0.1
        acts.append(request.act)
        wizard.see_prompt(ask(-1, "", PromptKind.INFORM))  # "I could not stop recording"
        wizard.reply(request.act.topic, request.act is WizardAct.REDO, now)
    assert acts == [WizardAct.STOP, WizardAct.STOP, WizardAct.REDO]


def test_a_paused_session_is_left_alone() -> None:
    wizard = knowing_wizard(Phase.OBSERVE_TARGET)
    wizard.see_state(SessionState("x", Phase.OBSERVE_TARGET, paused=True))
    assert wizard.next_request(0.0, replies=True) is None


@pytest.mark.parametrize(
    ("kind", "act"), [(PromptKind.WHAT_DO_I_USE, WizardAct.HANDED), (PromptKind.WHERE_DO_I_GO, WizardAct.POINTED)]
)
def test_a_question_is_answered_with_the_right_target_in_the_way_it_was_asked(kind: PromptKind, act: WizardAct) -> None:
    wizard = knowing_wizard(Phase.ASSIST)
    wizard.see_prompt(ask(0, "s1", kind))
    request = wizard.next_request(0.0, replies=True)
    assert request is not None and (request.act, request.object_id) == (act, "t1")


def test_a_target_an_earlier_assist_took_is_not_given_again() -> None:
    wizard = knowing_wizard(Phase.ASSIST, assists=(Assist("s0", "t1", 0),))
    wizard.see_prompt(ask(1, "s1"))
    request = wizard.next_request(0.0, replies=True)
    assert request is not None and request.object_id == "t0"


def test_a_robot_that_asks_for_help_with_one_step_again_and_again_is_told_to_leave_it_out() -> None:
    wizard = knowing_wizard(Phase.ASSIST)
    acts = []
    for now in range(3):
        wizard.see_prompt(ask(4, "s0", PromptKind.PUT_IT_RIGHT))
        request = wizard.next_request(float(now), replies=True)
        assert request is not None
        wizard.see_prompt(ask(-1, "", PromptKind.INFORM))  # the next may come before the reply
        wizard.reply(request.act.topic, True, float(now))
        acts.append(request.act)
    assert acts == [WizardAct.YES, WizardAct.YES, WizardAct.SKIP]


def test_each_prompt_is_answered_once_and_a_repeated_question_again() -> None:
    wizard = knowing_wizard(Phase.ASSIST)
    wizard.see_prompt(ask(0, "s0"))
    assert wizard.next_request(0.0, replies=True) is not None
    wizard.reply("wizard/handed", True, 0.1)
    assert wizard.next_request(9.0, replies=True) is None
    wizard.see_prompt(ask(0, "s0"))
    assert wizard.next_request(9.1, replies=True) is not None


def test_a_question_that_comes_before_the_reply_to_the_last_answer_is_answered_too() -> None:
    wizard = knowing_wizard(Phase.ASSIST)
    wizard.see_prompt(ask(0, "s0"))
    assert wizard.next_request(0.0, replies=True) is not None
    wizard.see_prompt(ask(1, "s1"))
    wizard.reply("wizard/handed", True, 0.1)
    request = wizard.next_request(0.2, replies=True)
    assert request is not None and request.object_id == "t1"


def test_the_wrong_step_gets_one_wrong_answer_and_then_the_right_one() -> None:
    wizard = knowing_wizard(Phase.ASSIST, wrong_step=0)
    answers = []
    for _ in range(2):
        wizard.see_prompt(ask(0, "s0"))
        request = wizard.next_request(0.0, replies=True)
        assert request is not None
        answers.append(request.object_id)
        wizard.reply("wizard/handed", True, 0.0)
    assert answers == ["t1", "t0"]


def test_an_object_the_wizard_does_not_recognise_is_skipped() -> None:
    wizard = knowing_wizard(Phase.ASSIST)
    wizard.see_prompt(ask(0, "s9"))
    request = wizard.next_request(0.0, replies=True)
    assert request is not None and request.act is WizardAct.SKIP


@given(st.permutations(range(6)), st.floats(-0.02, 0.02))
def test_objects_are_recognised_by_place_whatever_their_order(order: list[int], off: float) -> None:
    places = {f"name_{k}": (0.3 + 0.1 * (k % 3), -0.2 + 0.2 * (k // 3)) for k in range(6)}
    shuffled = {f"name_{k}": places[f"name_{k}"] for k in order}
    found = recognise(seen(Role.TARGET, shuffled, off), places)
    assert found == {f"t{i}": f"name_{k}" for i, k in enumerate(order)}


def test_what_stands_nowhere_near_is_not_recognised() -> None:
    assert recognise(seen(Role.SOURCE, {"ghost": (0.9, 0.9)}), dict(SOURCE.places)) == {}
    assert recognise(Scene(Role.SOURCE, ()), dict(SOURCE.places)) == {}


def test_without_a_free_right_target_there_is_no_answer() -> None:
    names = {Role.SOURCE: {"s0": "cup_a"}, Role.TARGET: {"t0": "bowl_a"}}
    assert right_target("s0", names, {"cup_a": ["bowl_a"]}, used=["t0"]) is None


@pytest.mark.parametrize(
    ("kind", "source_id", "targets", "answer"),
    [
        (PromptKind.CONFIRM_ASSIST, "s0", ("t0",), (WizardAct.YES, "")),
        (PromptKind.CONFIRM_ASSIST, "s0", ("t1",), (WizardAct.NO, "")),
        (PromptKind.IS_THIS_IT, "s1", ("t0",), (WizardAct.YES, "")),
        (PromptKind.IS_THIS_IT, "s0", ("t1",), (WizardAct.NO, "")),
        (PromptKind.WHICH_OF_TWO, "s0", ("t1", "t0"), (WizardAct.POINTED, "t0")),
        (PromptKind.WHICH_OF_TWO, "s0", ("t1", "t9"), (WizardAct.NO, "")),
    ],
)
def test_a_question_that_names_objects_is_answered_as_it_is_true(
    kind: PromptKind, source_id: str, targets: tuple[str, ...], answer: tuple[WizardAct, str]
) -> None:
    wizard = knowing_wizard(Phase.ASSIST)
    wizard.see_prompt(Prompt(kind, "?", 0, source_id, targets))
    request = wizard.next_request(0.0, replies=True)
    assert request is not None and (request.act, request.object_id) == answer


def test_an_object_that_was_taken_for_another_is_not_the_one_but_what_was_given_is_confirmed() -> None:
    given = (Assist("s0", "t0", 0), Assist("s1", "t0", 1))
    for kind, act in ((PromptKind.IS_THIS_IT, WizardAct.NO), (PromptKind.CONFIRM_ASSIST, WizardAct.YES)):
        wizard = knowing_wizard(Phase.ASSIST, assists=given)
        wizard.see_prompt(Prompt(kind, "?", 1, "s1", ("t0",)))
        request = wizard.next_request(0.0, replies=True)
        assert request is not None and request.act is act


def test_a_wrong_answer_is_denied_when_asked_about_and_its_step_answered_twice_more() -> None:
    wizard = knowing_wizard(Phase.ASSIST, wrong_step=0)
    done = []
    for prompt in (ask(0, "s0"), Prompt(PromptKind.CONFIRM_ASSIST, "?", 0, "s0", ("t1",)), *[ask(0, "s0")] * 3):
        wizard.see_prompt(prompt)
        request = wizard.next_request(0.0, replies=True)
        assert request is not None
        done.append((request.act, request.object_id))
        wizard.reply(request.act.topic, True, 0.0)
    right = (WizardAct.HANDED, "t0")
    assert done == [(WizardAct.HANDED, "t1"), (WizardAct.NO, ""), right, right, (WizardAct.SKIP, "")]


TOPICS = sorted({act.topic for act in WizardAct})
HAPPENINGS = st.one_of(
    st.builds(
        SessionState,
        st.just("x"),
        st.sampled_from(Phase),
        st.booleans(),
        st.integers(-1, 3),
        st.sampled_from([(), (Assist("s0", "t0"),)]),
        st.integers(0, 5),
        st.just("I am watching"),
    ),
    st.builds(
        Prompt,
        st.sampled_from(PromptKind),
        st.just("What?"),
        st.integers(0, 3),
        st.sampled_from(["s0", "s1"]),
        st.sampled_from([(), ("t0",), ("t1",), ("t0", "t1")]),
    ),
    st.sampled_from(Word),
    st.tuples(st.sampled_from(TOPICS), st.booleans()),
)


@given(st.lists(HAPPENINGS, max_size=40), st.sampled_from(list(REWORDINGS.values())), st.integers(-1, 3))
def test_in_other_words_the_same_happenings_make_the_wizard_send_the_same(
    happenings: list, words: Rewording, wrong_step: int
) -> None:
    sent: list[list] = []
    for rewording in (str, words):
        wizard = knowing_wizard(Phase.DEMONSTRATE, wrong_step)
        sent.append([])
        for second, happening in enumerate(happenings):
            received = reworded(happening, rewording)
            if isinstance(received, SessionState):
                wizard.see_state(received)
            elif isinstance(received, Prompt):
                wizard.see_prompt(received)
            elif isinstance(received, Word):
                wizard.on_word(received)
            else:
                wizard.reply(*received, 10.0 * second)
            sent[-1].append(wizard.next_request(10.0 * second, replies=True))
    assert sent[0] == sent[1]
