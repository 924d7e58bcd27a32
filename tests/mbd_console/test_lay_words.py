"""What a participant reads: every text in every language, things told apart by words, and no id anywhere."""

from __future__ import annotations

import dataclasses
import re
from string import Formatter

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console.participant import panels
from mbd_console.state import ConsoleState
from mbd_console.words import sentences
from mbd_console.words.sentences import lay_names
from mbd_console.words.texts import LANGUAGES, PageTexts, table, texts_in
from mbd_console.words.things import operator_names, thing_names
from mbd_interaction.synthetic import row_of_objects, stacking_task
from mbd_model.assists import Assist
from mbd_model.estimate import Feature, Mapping, MappingEstimate
from mbd_model.execution_progress import Progress, Purpose, Status
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task_words import names_in

COLORS = ("red", "blue", "green", "yellow", "", "mauve")
KINDS = ("cup", "bowl", "block", "unknown", "teapot")


def test_every_text_is_there_in_every_language_with_the_same_places_to_fill_in():
    def places(text: str) -> set[str]:
        return {name for _, name, _, _ in Formatter().parse(text) if name}

    for name, texts in table().items():
        assert set(texts) == set(LANGUAGES), name
        assert len({frozenset(places(text)) for text in texts.values()}) == 1, name


@pytest.mark.parametrize("asked", ["fr", "", None, 3, "<script>"])
def test_a_language_there_is_not_is_english(asked: object):
    assert texts_in(asked) == PageTexts("en")


things = st.builds(
    lambda color, kind, volume: (color, kind, volume),
    st.sampled_from(COLORS),
    st.sampled_from(KINDS),
    st.floats(1e-5, 1e-2),
)


@given(st.lists(things, min_size=1, max_size=7), st.sampled_from(list(LANGUAGES)))
def test_no_two_things_of_a_scene_have_one_name(made: list[tuple[str, str, float]], language: str):
    scene = Scene(
        Role.TARGET,
        tuple(
            SceneObject(
                f"t{n}", (0.5, 0.1 * n, 0.05), (0.05, 0.05, 0.05), color_name=color, object_class=kind, volume=volume
            )
            for n, (color, kind, volume) in enumerate(made)
        ),
    )
    names = thing_names(scene, PageTexts(language), {i: float(n) for n, i in enumerate(scene.ids)})
    assert len({n.label for n in names.values()}) == len({n.accusative for n in names.values()}) == len(made)
    assert not [n for n in names.values() if re.search(r"\bt\d", n.label)]


@given(st.lists(things, min_size=1, max_size=7))
def test_the_operator_s_pages_name_things_as_the_robot_s_own_questions_do(made: list[tuple[str, str, float]]):
    """The robot asks in English, and calls what fits no class by its colour alone: "the red"."""
    scene = Scene(
        Role.SOURCE,
        tuple(
            SceneObject(f"s{n}", (0.5, 0.1 * n, 0.05), (0.05,) * 3, color_name=color, object_class=kind)
            for n, (color, kind, _) in enumerate(made)
        ),
    )
    english = {i: name.label for i, name in operator_names(scene, PageTexts()).items()}
    asked = names_in(scene)
    named = [o.object_id for o in scene.objects if o.object_class != "unknown" or not o.color_name]
    assert {i: english[i] for i in named} == {i: asked[i] for i in named}
    for language in LANGUAGES:
        assert len({n.label for n in operator_names(scene, PageTexts(language)).values()}) == len(made)


def test_things_are_named_by_size_color_and_kind_in_both_languages():
    cups = tuple(
        SceneObject(i, (0.5, y, 0.05), (side, side, side), color_name=color, object_class="cup")
        for i, y, side, color in (("a", 0.1, 0.05, "red"), ("b", 0.2, 0.09, "red"), ("c", 0.3, 0.05, "red"))
    )
    scene = Scene(Role.SOURCE, cups)
    along = {"a": 1.0, "b": 2.0, "c": 3.0}
    english, german = thing_names(scene, PageTexts("en"), along), thing_names(scene, PageTexts("de"), along)
    assert [english[i].accusative for i in "abc"] == [
        "the small red cup on the left",
        "the big red cup",
        "the small red cup on the right",
    ]
    assert german["b"].accusative == "den großen roten Becher"
    assert german["b"].nominative == "der große rote Becher"
    assert german["b"].label == "großer roter Becher"


def believing(**changes: object) -> ConsoleState:
    task = stacking_task(4)
    state = ConsoleState(
        session=SessionState("s", Phase.ASSIST, step_index=0, assists=(Assist("s3", "t3", 2),)),
        prompt=Prompt(PromptKind.WHAT_DO_I_USE, "What do I use now? (s1)", 0, "s1"),
        task=task,
        source=task.source,
        target=row_of_objects(Role.TARGET, "t", 4),
        estimate=MappingEstimate("mbd", Mapping((("s1", "t2"), ("s3", "t3"))), 0.00161, (Feature.HUE_SHIFT,)),
        threshold=0.02,
    )
    return dataclasses.replace(state, **changes)


def shown(state: ConsoleState, texts: PageTexts) -> str:
    names = lay_names(state, texts)
    parts = (
        panels.dialogue_panel(state, texts, names),
        panels.sure_panel(state, texts),
        panels.plan_panel(state, texts, names),
        panels.why_panel(state, texts),
        panels.spoken(state, texts, names),
    )
    return re.sub(r"<[^>]*>", " ", " ".join(parts))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("phase", Phase)
@pytest.mark.parametrize("kind", PromptKind)
def test_no_id_no_feature_s_name_and_no_number_of_the_method_is_shown(phase: Phase, kind: PromptKind, language: str):
    prompt = Prompt(kind, "s1 t1 hue_shift", 0, "s1", ("t1", "t2"), ("s1", "s2"))
    progress = Progress(0, Status.UNDER_WAY, "t1", (), Purpose.PLACE, "t1", "t2")
    state = believing(prompt=prompt, progress=progress)
    state = dataclasses.replace(state, session=dataclasses.replace(state.session, phase=phase))
    words = shown(state, PageTexts(language))
    assert not re.search(r"\b[st]\d\b|hue_shift|0\.0|\{|\}", words), words


def test_a_belief_is_a_sentence_about_what_goes_where():
    lines = sentences.plan(believing(), PageTexts("en"), lay_names(believing(), PageTexts("en")))
    assert any(line.startswith("I will put the ") and " where you put the " in line for line in lines)
    assert any(line.endswith("(you told me).") for line in lines)
    assert any(line.startswith("I do not know yet") for line in lines)


@given(st.floats(0.0, 1.0), st.floats(0.001, 1.0))
def test_the_bar_passes_its_mark_exactly_when_the_robot_goes_on_alone(confidence: float, threshold: float):
    estimate = dataclasses.replace(believing().estimate, confidence=confidence)
    for confident in (False, True):
        level = sentences.sureness(believing(estimate=estimate, threshold=threshold, confident=confident))
        assert level is not None
        assert 0.0 <= level <= 1.0
        assert (level >= sentences.SURE_FROM) == confident


def test_a_pause_and_a_stop_are_told_before_anything_else():
    texts = PageTexts("en")
    state = believing()
    paused = dataclasses.replace(state, session=dataclasses.replace(state.session, paused=True))
    assert sentences.robot_says(paused, texts, lay_names(paused, texts)) == "We take a break."
    stands = dataclasses.replace(paused, standing="a hand on the stop")
    assert sentences.robot_says(stands, texts, lay_names(stands, texts)).startswith("I have stopped")
    assert sentences.arm_does(stands, texts, lay_names(stands, texts)) == "stands still"


@pytest.mark.parametrize("language", LANGUAGES)
def test_while_a_form_is_shown_nothing_else_is_wanted_and_the_button_is_named_as_on_the_form(language: str):
    """Else the robot asks for one thing in large letters, and the line below for the form."""
    texts = PageTexts(language)
    state = dataclasses.replace(believing(), study=dataclasses.replace(believing().study, shown="consent"))
    names = lay_names(state, texts)
    assert sentences.robot_says(state, texts, names) == panels.spoken(state, texts, names) == texts("say_form")
    panel = panels.dialogue_panel(state, texts, names)
    assert texts("form_send") in panel
    assert "question" not in panel.replace("data-question", "")


@pytest.mark.parametrize("language", LANGUAGES)
def test_who_is_to_point_is_told_that_it_is_on_the_table(language: str):
    """Who holds a tablet points at the picture on it otherwise, where nothing happens."""
    table = {"en": "on the table", "de": "auf dem Tisch"}[language]
    texts = PageTexts(language)
    pointing = [texts(f"you_{kind.name}") for kind in PromptKind if texts.has(f"you_{kind.name}")]
    pointing = [words for words in pointing if "oint at" in words or "eigen Sie" in words]
    assert len(pointing) >= 5
    assert all(table in words for words in pointing), pointing
    assert table in panels.only_shown(texts)


@pytest.mark.parametrize("phase", [Phase.DONE, Phase.ABORTED])
def test_once_it_is_over_the_robot_plans_nothing_and_does_not_say_that_it_saw_nothing(phase: Phase):
    state = dataclasses.replace(believing(), session=SessionState("s", phase))
    assert sentences.plan(state, PageTexts("en"), lay_names(state, PageTexts("en"))) == ()
    words = shown(state, PageTexts("en"))
    assert "I will" not in words and "not seen" not in words
    assert "over" in words
