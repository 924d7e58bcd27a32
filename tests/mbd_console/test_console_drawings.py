"""The pages' pictures and panels show what is so, and show text from elsewhere as text."""

from __future__ import annotations

import dataclasses
import re
import xml.etree.ElementTree as ET
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console import panels
from mbd_console import state as console_state
from mbd_console.confidence_drawing import confidence_drawing
from mbd_console.live_drawing import live_overlay
from mbd_console.mapping_drawing import DrawingWords, mapping_drawing
from mbd_console.outlines import outlines, point_on_table
from mbd_console.state import Confidence, ConsoleState
from mbd_console.status.event_log import Tone
from mbd_console.words.sentences import lay_names
from mbd_console.words.texts import ENGLISH
from mbd_interaction.synthetic import row_of_objects, stacking_task
from mbd_model.assists import Assist
from mbd_model.camera.view import CameraView
from mbd_model.estimate import Feature, Mapping, MappingEstimate
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep

VIEW = CameraView.from_parameters((600, 600, 320, 240), (640, 480), (0.6, 0.3, 1.4), (-0.70710678, 0.70710678, 0, 0))
PAIRS = (("s1", "t2"), ("s2", "t1"), ("s3", "t3"), ("s4", "t4"))


def believing(phase: Phase = Phase.ASSIST, *, step_index: int = 0) -> ConsoleState:
    """Four source and four target objects, a mapping, and one assist: s3 is t3."""
    task = stacking_task(4)
    return ConsoleState(
        session=SessionState("s", phase, step_index=step_index, assists=(Assist("s3", "t3", 2),)),
        prompt=Prompt(PromptKind.WHAT_DO_I_USE, "What do I use now?", 0, "s1"),
        question=3,
        task=task,
        source=task.source,
        target=row_of_objects(Role.TARGET, "t", 4),
        estimate=MappingEstimate("mbd", Mapping(PAIRS), 0.01, (Feature.SIZE,), num_assists=1),
        threshold=0.02,
        view=VIEW,
    )


def poisoned(text: str) -> ConsoleState:
    """A state in which everything that came from elsewhere is ``text``."""
    thing = SceneObject(text, (0.5, 0.2, 0.05), (0.06, 0.06, 0.1), color_name=text, object_class=text)
    source, target = Scene(Role.SOURCE, (thing,)), Scene(Role.TARGET, (thing,))
    task = Task(source, (TaskStep(0, StepKind.PICK, text, 0.0),), (text,))
    estimate = MappingEstimate("mbd", Mapping(((text, text),)), 0.1, (Feature.HUE,), warnings=(text,))
    state = ConsoleState(
        session=SessionState(text, Phase.ASSIST, step_index=0, assists=(Assist(text, text, 0),), detail=text),
        prompt=Prompt(PromptKind.WHAT_DO_I_USE, text, 0, text),
        task=task,
        source=source,
        target=target,
        estimate=estimate,
        speech=text,
        view=VIEW,
    )
    return console_state.logged(console_state.logged(state, 0.0, Tone.NOTE, text, text), 0.0, Tone.REFUSED, text, text)


def everything(state: ConsoleState) -> str:
    return "".join(
        (
            live_overlay(state, clickable=True),
            mapping_drawing(state, {}),
            confidence_drawing(state.confidences, state.threshold),
            panels.phase_bar(state),
            panels.prompt_banner(state),
            panels.prompt_banner(state, 0),
            panels.last_reply(state),
            panels.steps_panel(state, 0),
            panels.assists_panel(state),
            panels.belief_line(state),
            panels.log_panel(state),
        )
    )


def elements(markup: str) -> list[ET.Element]:
    return list(ET.fromstring(f"<all>{markup}</all>").iter())


PRINTABLE = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn")), min_size=1, max_size=30)


@given(text=PRINTABLE | st.sampled_from(["<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "'&<b>"]))
def test_whatever_text_comes_it_adds_no_element_and_no_attribute(text: str):
    shown, plain = elements(everything(poisoned(text))), elements(everything(poisoned("x")))
    assert [(e.tag, sorted(e.attrib)) for e in shown] == [(e.tag, sorted(e.attrib)) for e in plain]


def test_text_is_shown_as_it_was_written():
    script = '<img src=x onerror="alert(1)">'
    texts = [t.strip() for e in elements(panels.log_panel(poisoned(script))) for t in e.itertext()]
    assert script in texts


def arrows(markup: str) -> dict[str, str]:
    return {e.attrib["data-pair"]: e.attrib["class"] for e in elements(markup) if "data-pair" in e.attrib}


def test_each_pair_of_the_mapping_is_one_arrow_and_what_the_teacher_assisted_looks_different():
    drawn = arrows(mapping_drawing(believing(), {}))
    assert set(drawn) == {f"{s}>{t}" for s, t in PAIRS}
    assert {pair for pair, kind in drawn.items() if kind == "arrow assisted"} == {"s3>t3"}


def test_an_assist_outweighs_an_estimate_that_does_not_know_it_yet():
    state = believing()
    session = dataclasses.replace(state.session, assists=(Assist("s1", "t4", 0),))
    assert "s1>t4" in arrows(mapping_drawing(dataclasses.replace(state, session=session), {}))


@pytest.mark.parametrize("missing", [{"source": None}, {"target": None}, {"view": None}, {"estimate": None}])
def test_a_drawing_with_something_missing_is_still_one(missing: dict[str, None]):
    state = dataclasses.replace(believing(), **missing)
    assert elements(everything(state))
    if "estimate" not in missing:
        assert arrows(mapping_drawing(state, {})) == {}


SPOT = st.tuples(st.floats(0.3, 0.9), st.floats(-0.1, 0.7))
EDGE = st.tuples(st.floats(0.30, 0.34), st.floats(-0.1, 0.7))  # the table's edge that is lowest in the picture


@pytest.mark.parametrize("spoken_to", ["operator", "participant"])
@given(spots=st.lists(SPOT, min_size=1, max_size=6) | st.lists(EDGE, min_size=6, max_size=6))
def test_names_of_objects_cover_no_other_name_and_stay_in_their_picture(
    spoken_to: str, spots: list[tuple[float, float]]
):
    def things(prefix: str) -> tuple[SceneObject, ...]:
        """They differ in color only, so that their names are long."""
        return tuple(
            SceneObject(
                f"{prefix}{k}", (x, y, 0.05), (0.06, 0.06, 0.1), color_name=COLORS[k], object_class="rectangular_box"
            )
            for k, (x, y) in enumerate(spots)
        )

    state = dataclasses.replace(
        believing(), task=None, source=Scene(Role.SOURCE, things("s")), target=Scene(Role.TARGET, things("t"))
    )
    names = lay_names(state, ENGLISH) if spoken_to == "participant" else None
    drawn = elements(mapping_drawing(state, {}, DrawingWords(ENGLISH, names)))
    panels_drawn = [e for e in drawn if e.get("class") == "frame"]
    tags = [group.find("rect") for group in drawn if group.get("class") == "tag"]
    assert (len(panels_drawn), len(tags)) == (2, 2 * len(spots))
    assert all(any(lies_in(tag, frame) for frame in panels_drawn) for tag in tags)
    assert not [(a, b) for a, b in combinations(map(sides, tags), 2) if overlap(a, b)]


COLORS = ("red", "yellow", "green", "blue", "purple", "orange")
Sides = tuple[float, float, float, float]


def sides(rect: ET.Element) -> Sides:
    """Left, top, right, bottom."""
    x, y, width, height = (float(rect.attrib[name]) for name in ("x", "y", "width", "height"))
    return x, y, x + width, y + height


def overlap(a: Sides, b: Sides) -> bool:
    return all(a[k] < b[k + 2] - 0.1 and b[k] < a[k + 2] - 0.1 for k in (0, 1))


def lies_in(rect: ET.Element, frame: ET.Element) -> bool:
    (left, top, right, bottom), around = sides(rect), sides(frame)
    within = around[0] - 0.1 <= left and right <= around[2] + 0.1
    return within and around[1] - 0.1 <= top and bottom <= around[3] + 0.1


@given(
    x=st.floats(0.3, 0.8),
    y=st.floats(-0.1, 0.6),
    yaw=st.floats(-3.0, 3.0),
    width=st.floats(0.02, 0.2),
    height=st.floats(0.02, 0.3),
)
def test_an_outline_goes_around_its_object(x: float, y: float, yaw: float, width: float, height: float):
    thing = SceneObject("a", (x, y, height / 2), (width, 0.05, height), yaw)
    (outline,) = outlines(VIEW, (thing,))
    corners = np.array(outline.corners)
    edges = np.roll(corners, -1, axis=0) - corners
    inside = np.array(outline.middle) - corners
    turns = edges[:, 0] * inside[:, 1] - edges[:, 1] * inside[:, 0]
    assert (turns > 0).all() or (turns < 0).all()


def test_what_lies_behind_the_camera_has_no_outline():
    assert outlines(VIEW, (SceneObject("a", (0.5, 0.0, 3.0), (0.1, 0.1, 0.1)),)) == ()


@given(u=st.floats(0, 640), v=st.floats(0, 480), tilt=st.floats(-0.2, 0.2), height=st.floats(-0.1, 0.3))
def test_a_pixel_of_the_table_and_its_point_are_each_others_picture(u: float, v: float, tilt: float, height: float):
    plane = (tilt, 0.0, 1.0, -height)
    point = point_on_table(VIEW, plane, (u, v))
    assert point is not None
    assert float(np.dot(plane[:3], point)) + plane[3] == pytest.approx(0.0, abs=1e-9)
    assert VIEW.project(np.array([point]))[0] == pytest.approx((u, v), abs=1e-6)


@pytest.mark.parametrize("pixel", [(-1.0, 5.0), (700.0, 5.0), (5.0, 481.0)])
def test_a_pixel_outside_the_picture_shows_no_table(pixel: tuple[float, float]):
    assert point_on_table(VIEW, (0.0, 0.0, 1.0, 0.0), pixel) is None


def test_only_the_operator_and_only_when_asked_can_choose_on_the_picture():
    choosing = live_overlay(believing(), clickable=True)
    assert 'class="overlay choosing"' in choosing
    assert "data-place" not in choosing
    assert "data-place" in live_overlay(believing(step_index=1), clickable=True)
    assert "choosing" not in live_overlay(believing(), clickable=False)
    assert "choosing" not in live_overlay(believing(Phase.DEMONSTRATE), clickable=True)


def test_objects_carry_the_keys_that_choose_them():
    markup = live_overlay(believing(), clickable=True)
    keys = re.findall(r'data-object="(\w+)".*?class="keytext"[^>]*>(\d)<', markup)
    assert sorted(keys) == [("t1", "1"), ("t2", "2"), ("t3", "3"), ("t4", "4")]


@given(values=st.lists(st.floats(0.0, 1.0), max_size=9), threshold=st.floats(0.0, 1.0))
def test_the_confidence_curve_rises_where_the_confidence_does_and_stays_in_its_frame(
    values: list[float], threshold: float
):
    points = [Confidence(10.0 * k, v, k) for k, v in enumerate(values)]
    dots = [e for e in elements(confidence_drawing(points, threshold)) if e.tag == "circle"]
    heights = [float(d.attrib["cy"]) for d in dots]
    assert len(dots) == len(values)
    assert all(0 <= h <= 170 for h in heights)
    for (a, high_a), (b, high_b) in pairwise(zip(values, heights, strict=True)):
        assert (b - a) * (high_a - high_b) >= -0.1


def test_the_assists_are_listed_oldest_first_and_the_last_names_the_key_that_withdraws_it():
    session = dataclasses.replace(believing().session, assists=(Assist("s3", "t3", 2), Assist("s1", "t2", 0)))
    markup = panels.assists_panel(dataclasses.replace(believing(), session=session))
    rows = ["".join(e.itertext()) for e in elements(markup) if e.tag == "li"]
    assert rows == ["1step 3: s3 is t3, handed", "2step 1: s1 is t2, handedwithdrawn by U"]
    over = dataclasses.replace(believing(), session=dataclasses.replace(session, phase=Phase.DONE))
    assert "withdrawn" not in panels.assists_panel(over)


def test_where_nothing_goes_on_by_itself_the_banner_names_the_key_that_does():
    for phase, key in ((Phase.ABORTED, "P"), (Phase.EXECUTE, "N")):
        banner = panels.prompt_banner(
            dataclasses.replace(believing(phase), prompt=Prompt(PromptKind.INFORM, "I wait."))
        )
        assert f"<kbd>{key}</kbd>" in banner
    meant = panels.prompt_banner(believing(), meant_step=2)
    assert "<kbd>M</kbd>" in meant and "<kbd>Esc</kbd>" in meant


def test_each_step_states_who_states_which_object_it_is_about():
    rows = {
        e.attrib["data-step"]: "".join(e.itertext())
        for e in elements(panels.steps_panel(believing()))
        if "data-step" in e.attrib
    }
    assert "t2" in rows["0"] and "believed" in rows["0"]
    assert "t3" in rows["2"] and rows["2"].endswith("assisted")
    assert rows["5"].endswith("assisted before")
