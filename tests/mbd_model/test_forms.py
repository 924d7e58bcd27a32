"""Forms: what a file may say, what an answer may be, and what the answers score."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from mbd_model.forms.answers import FilledForm, declined, filled
from mbd_model.forms.form import FormError, ItemKind
from mbd_model.forms.reading import form_of, read_form, shipped_forms
from mbd_model.ros import conversions

FREE: dict[str, Any] = {
    "form": "free", "version": 1, "title": "Free", "items": [{"name": "a", "kind": "text", "text": "What?"}]
}  # fmt: skip


@pytest.mark.parametrize("name", shipped_forms())
def test_a_shipped_form_is_there_in_both_languages_and_says_where_it_is_from(name: str):
    form = read_form(name)
    assert form.name == name
    assert {"en", "de"} <= set(form.languages)
    assert form.source or name in ("consent", "demographics", "closing")


def sus(answers: list[int]) -> dict[str, object]:
    return {f"sus{number:02d}": answer for number, answer in enumerate(answers, start=1)}


@given(st.lists(st.integers(1, 5), min_size=10, max_size=10))
def test_the_sus_is_scored_as_brooke_scores_it(answers: list[int]):
    odd, even = sum(answers[0::2]), sum(answers[1::2])
    (score,) = filled(read_form("sus"), "en", sus(answers)).scores
    assert score == ("sus", pytest.approx(2.5 * ((odd - 5) + (25 - even))))


def test_the_raw_tlx_is_the_mean_of_the_six_and_there_is_none_while_one_is_open():
    form = read_form("nasa_tlx")
    given_for = dict(zip([i.name for i in form.items], (0, 5, 10, 100, 50, 15), strict=True))
    assert filled(form, "en", given_for).scores == (("raw_tlx", 30.0),)
    assert filled(form, "en", {**given_for, "effort": None}).scores == ()


def test_a_reversed_pair_of_godspeed_counts_from_the_other_end():
    form = read_form("godspeed")
    safe = filled(form, "en", {"safety1": 5, "safety2": 5, "safety3": 1})
    assert dict(safe.scores) == {"safety": 5.0}


def test_who_does_not_agree_to_every_sentence_has_not_consented():
    form = read_form("consent")
    agreed = {"informed": True, "takes_part": True, "room_recording": "no"}
    assert filled(form, "de", agreed).answers[2].shown == "nein"
    for name in agreed:
        with pytest.raises(FormError, match="still open"):
            filled(form, "de", {k: v for k, v in agreed.items() if k != name})
    with pytest.raises(FormError, match="still open"):
        filled(form, "de", {**agreed, "takes_part": False})
    assert declined(form, "de") == FilledForm("consent", "1", "de", declined=True)


values = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.lists(st.text()))


@given(st.sampled_from(shipped_forms()), st.data())
def test_whatever_is_given_is_an_answer_of_its_item_or_a_sentence_of_refusal(name: str, data: st.DataObject):
    form = read_form(name)
    item = data.draw(st.sampled_from(form.items))
    try:
        answers = filled(form, "en", {item.name: data.draw(values)}).answers
    except FormError as refusal:
        assert form.name in str(refusal) or "still open" in str(refusal)
        return
    (answer,) = [a for a in answers if a.item == item.name]
    if item.kind is ItemKind.SCALE and answer.answered:
        assert item.scale is not None
        assert answer.number in item.scale.values
    elif item.kind is ItemKind.NUMBER and answer.answered:
        assert item.limits[0] <= answer.number <= item.limits[1]
    elif item.kind is ItemKind.CHOICE and answer.answered:
        assert answer.value in dict(item.options)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"title": None}, "title"),
        ({"items": []}, "no item"),
        ({"items": [{"name": "a", "kind": "tekst", "text": "?"}]}, "text, choice, scale"),
        ({"items": [{"name": "a", "kind": "choice", "text": "?", "options": {"one": "One"}}]}, "two or more"),
        ({"items": [{"name": "a", "kind": "scale", "text": "?", "scale": "tlx"}]}, "tlx"),
        ({"items": [{"name": "a", "kind": "number", "text": "?", "limits": [9, 1]}]}, "limits"),
        ({"itmes": []}, "itmes"),
        ({"consent": True}, "agree"),
        ({"scores": [{"name": "s", "rule": "mean", "items": ["b"]}]}, "b"),
    ],
)
def test_a_mistake_in_a_file_is_named_with_its_place(change: dict[str, Any], word: str, tmp_path: Path):
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({**FREE, **change}))
    with pytest.raises(FormError, match=word) as refused:
        read_form(str(path))
    assert str(path) in str(refused.value)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"a: [", b"[]", b"", b"!!python/object:os.system x"])
def test_a_file_that_is_no_form_is_refused(content: bytes, tmp_path: Path):
    path = tmp_path / "mine.yml"
    path.write_bytes(content)
    with pytest.raises(FormError, match=r"mine\.yml"):
        read_form(str(path))


def test_a_form_that_is_not_there_is_answered_with_those_that_are():
    with pytest.raises(FormError, match="nasa_tlx"):
        read_form("nasa")


def test_a_lab_s_own_form_needs_no_more_than_its_words():
    form = form_of(FREE)
    answer = filled(form, "de", {"a": "two\nlines \x07"}).answers[0]
    assert (form.languages, answer.text, answer.value) == (("en",), "What?", "two\nlines")


@given(st.lists(st.integers(1, 5), min_size=10, max_size=10), st.booleans())
def test_a_filled_form_comes_back_from_its_message(answers: list[int], left_open: bool):
    form = filled(read_form("sus"), "de", sus(answers[: 9 if left_open else 10]))
    msg = conversions.form_to_msg(form, "p01", 7, (1.5, 60.0))
    back = conversions.form_from_msg(msg)
    assert (msg.session, msg.phase, msg.opened.sec, msg.header.stamp.sec) == ("p01", 7, 1, 60)
    assert (back.form, back.version, back.language, back.scores) == (form.form, "1986", "de", form.scores)
    for mine, its in zip(form.answers, back.answers, strict=True):
        assert (mine.item, mine.value, mine.shown) == (its.item, its.value, its.shown)
        assert mine.number == its.number or (math.isnan(mine.number) and math.isnan(its.number))
