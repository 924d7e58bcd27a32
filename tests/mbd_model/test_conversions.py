"""Every value of the shared vocabulary survives its message, through real serialization."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import IntEnum

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_model.assists import Assist, AssistKind, Denial
from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.errors import MbdError
from mbd_model.estimate import Feature, Mapping, MappingEstimate, QuestionKind
from mbd_model.execution_progress import Failure, Progress, Purpose, Status, Verdict
from mbd_model.objects import FeatureDeviations, Relation, Role, Scene, SceneObject
from mbd_model.ros import conversions as c
from mbd_model.ros.conversions.estimate import KIND_TO_CODE
from mbd_model.session import Awaited, GripperWord, Phase, Prompt, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep
from mbd_msgs import msg as m
from mbd_msgs.srv import ReviseTask
from rclpy.serialization import deserialize_message, serialize_message

number = st.floats(-10, 10, allow_nan=False)
positive = st.floats(1e-3, 2.0)
word = st.text(st.characters(min_codepoint=33, max_codepoint=0x2FF), min_size=1, max_size=8)
stamp = st.integers(0, 10**15).map(lambda ns: ns / 1e9)
triple = st.tuples(number, number, number)


@st.composite
def deviations(draw: st.DrawFn, hue: float | None) -> FeatureDeviations | None:
    """Of an object with that hue; now and then none."""
    if draw(st.booleans()):
        return None
    three = st.tuples(positive, positive, positive)
    of_hue = None if hue is None else draw(positive)
    single = (draw(positive), draw(positive), of_hue, draw(positive))
    return FeatureDeviations(draw(three), draw(three), draw(three), *single)


@st.composite
def scenes(draw: st.DrawFn, role: Role = Role.SOURCE) -> Scene:
    ids = draw(st.lists(word, min_size=1, max_size=4, unique=True))
    hues = [draw(st.none() | st.floats(0, 360, exclude_max=True)) for _ in ids]
    objects = tuple(
        SceneObject(
            object_id=i,
            centroid=draw(triple),
            size=draw(st.tuples(positive, positive, positive)),
            yaw=draw(number),
            hue=hue,
            saturation=draw(st.floats(0, 1)),
            color_name=draw(word),
            object_class=draw(word),
            class_score=draw(st.floats(0, 1)),
            affordances=draw(st.frozensets(word, max_size=3)),
            properties=draw(st.frozensets(word, max_size=3)),
            relations=tuple((draw(st.sampled_from(Relation)), other) for other in ids if other != i),
            volume=draw(positive),
            deviations=draw(deviations(hue)),
        )
        for i, hue in zip(ids, hues, strict=True)
    )
    return Scene(role, objects, draw(stamp), draw(word))


@st.composite
def tasks(draw: st.DrawFn) -> Task:
    scene = draw(scenes())
    steps = tuple(
        TaskStep(
            index=k,
            kind=draw(st.sampled_from(StepKind)),
            primary_object=draw(st.sampled_from(scene.ids)),
            distance=draw(positive),
            runner_up=draw(word),
            runner_up_distance=draw(positive | st.just(math.inf)),
            start=draw(stamp),
            end=draw(stamp),
            tool_position=draw(triple),
            tool_quaternion=(0.0, 0.6, 0.8, 0.0),
            offset=draw(triple),
        )
        for k in range(draw(st.integers(0, 3)))
    )
    problems = tuple(draw(st.lists(word, max_size=2)))
    open_ends = tuple(k for k in range(len(problems)) if draw(st.booleans()))
    return Task(scene, steps, problems, draw(stamp), open_ends)


assists = st.builds(Assist, word, word, st.integers(0, 99), st.sampled_from(AssistKind), stamp, st.booleans())
denials = st.lists(st.builds(Denial, word, word, st.integers(0, 99), stamp), max_size=3).map(tuple)
words = st.lists(word, max_size=2).map(tuple)
mappings = st.builds(Mapping, st.lists(st.tuples(word, word), max_size=4).map(tuple), number)
features = st.lists(st.sampled_from(Feature), max_size=7, unique=True).map(tuple)
estimates = st.builds(
    MappingEstimate,
    strategy=word,
    mapping=mappings,
    confidence=st.floats(0, 1),
    winning=features,
    runner_up=features,
    alternatives=st.lists(mappings, max_size=3).map(tuple),
    ties=st.integers(1, 2**63),
    num_assists=st.integers(0, 99),
    warnings=st.lists(word, max_size=2).map(tuple),
    next_question=word,
    information_gain=positive,
    best_guess=mappings,
    obeying=mappings,
    doubted=st.none() | assists.filter(lambda a: a.source_id),
    doubt=st.floats(0, 1),
    question_kind=st.sampled_from(QuestionKind),
    question_targets=words,
    threshold=st.just(0.02),
)


def over_the_wire(msg):
    return deserialize_message(serialize_message(msg), type(msg))


@given(scenes())
def test_a_scene_survives_its_message(scene: Scene):
    assert c.scene_from_msg(over_the_wire(c.scene_to_msg(scene))) == scene


@given(tasks())
def test_a_task_survives_its_message(task: Task):
    assert c.task_from_msg(over_the_wire(c.task_to_msg(task))) == task


@given(st.lists(assists, max_size=4).map(tuple), denials, stamp)
def test_a_list_of_assists_and_denials_survives_its_message(
    values: tuple[Assist, ...], denied: tuple[Denial, ...], when: float
):
    msg = over_the_wire(c.assists_to_msg(values, when, "s", denied))
    assert (c.assists_from_msg(msg), c.denials_from_msg(msg)) == (values, denied)


@given(estimates, st.tuples(stamp, stamp, stamp))
def test_an_estimate_survives_its_message_and_is_stamped_by_its_latest_input(
    estimate: MappingEstimate, stamps: tuple[float, float, float]
):
    times = tuple(c.time_to_msg(s) for s in stamps)
    msg = over_the_wire(c.estimate_to_msg(estimate, session="s", threshold=0.02, stamps=times))
    assert c.estimate_from_msg(msg) == estimate
    assert c.time_from_msg(msg.header.stamp) == max(c.time_from_msg(t) for t in times)


@given(st.builds(Prompt, st.sampled_from(PromptKind), word, st.integers(-1, 99), word, words, words), stamp)
def test_a_prompt_survives_its_message(prompt: Prompt, when: float):
    assert c.prompt_from_msg(over_the_wire(c.prompt_to_msg(prompt, when))) == prompt


@given(
    st.builds(
        SessionState,
        word,
        st.sampled_from(Phase),
        st.booleans(),
        st.integers(-1, 99),
        st.lists(assists, max_size=3).map(tuple),
        st.integers(0, 2**31),
        word,
        st.booleans(),
        st.sampled_from(Awaited),
        denials,
        st.lists(st.integers(0, 99), max_size=3).map(tuple),
        st.lists(st.builds(GripperWord, stamp, st.booleans()), max_size=3).map(tuple),
    ),
    stamp,
)
def test_a_session_state_survives_its_message(state: SessionState, when: float):
    assert c.state_from_msg(over_the_wire(c.state_to_msg(state, when))) == state


@given(
    st.builds(StepCorrection, st.sampled_from(CorrectionKind), st.integers(0, 99), st.integers(0, 99), word, stamp),
    stamp,
)
def test_a_correction_survives_its_message_and_its_request(correction: StepCorrection, when: float):
    assert c.correction_from_msg(over_the_wire(c.correction_to_msg(correction, when))) == correction
    assert c.correction_from_msg(over_the_wire(c.correction_to_request(correction))) == correction


statuses = st.sampled_from(Status)


@given(
    st.builds(
        Progress,
        st.integers(-1, 99),
        statuses,
        word,
        st.lists(statuses, max_size=6).map(tuple),
        st.sampled_from(Purpose),
        word,
        word,
        st.sampled_from(Failure),
    )
)
def test_progress_survives_its_message(progress: Progress):
    msg = c.progress_to_msg(progress, "s", c.time_to_msg(2.5))
    assert c.progress_from_msg(over_the_wire(msg)) == progress


@pytest.mark.parametrize(
    ("values", "kind", "prefix"),
    [
        (Phase, m.SessionState, ""),
        (Awaited, m.SessionState, "AWAITING_"),
        (PromptKind, m.Prompt, ""),
        (Status, m.Progress, ""),
        (Purpose, m.Progress, "PURPOSE_"),
        (Failure, m.Progress, "FAILURE_"),
        (Verdict, m.SessionState, "VERDICT_"),
        (CorrectionKind, m.WizardRevision, ""),
        (CorrectionKind, ReviseTask.Request, ""),
    ],
)
def test_every_value_has_the_code_of_its_message_and_no_code_is_without_a_value(
    values: type[IntEnum], kind: type, prefix: str
):
    others = [p for p in ("AWAITING_", "PURPOSE_", "FAILURE_", "VERDICT_") if p != prefix]
    codes = {
        name.removeprefix(prefix): getattr(kind, name)
        for name in dir(type(kind))
        if name.isupper() and name.startswith(prefix) and not name.startswith(("_", *others))
    }
    assert {value.name: value.value for value in values} == codes


def test_every_kind_of_question_has_a_code_and_what_an_older_version_left_out_is_the_open_one():
    assert len(set(KIND_TO_CODE.values())) == len(KIND_TO_CODE) == len(QuestionKind)
    assert c.estimate_from_msg(m.MappingEstimate(strategy="mbd")).question_kind is QuestionKind.WHAT_NEXT
    with pytest.raises(ValueError, match="question_kind is 9"):
        c.estimate_from_msg(m.MappingEstimate(strategy="mbd", question_kind=9))


def test_an_estimate_that_doubts_an_assist_is_never_confident():
    doubting = MappingEstimate("evidence", Mapping((("s1", "t1"),)), 1.0, doubted=Assist("s1", "t2"), doubt=0.6)
    zero = c.time_to_msg(0.0)
    for estimate, confident in ((doubting, False), (replace(doubting, doubted=None), True)):
        msg = c.estimate_to_msg(estimate, session="", threshold=0.02, stamps=(zero, zero, zero))
        assert msg.confident is confident


def test_an_estimate_without_a_mapping_is_never_confident():
    nothing = MappingEstimate("mbd", Mapping(()), confidence=1.0)
    zero = c.time_to_msg(0.0)
    assert not c.estimate_to_msg(nothing, session="", threshold=0.02, stamps=(zero, zero, zero)).confident


def test_a_scene_of_no_known_role_is_refused_by_number():
    msg = c.scene_to_msg(Scene(Role.SOURCE, ()))
    msg.role = 7
    with pytest.raises(MbdError, match="role 7"):
        c.scene_from_msg(msg)


def test_two_objects_of_one_id_are_refused_by_name():
    cup = SceneObject("cup", (0, 0, 0), (0.1, 0.1, 0.1))
    with pytest.raises(MbdError, match="cup"):
        Scene(Role.SOURCE, (cup, cup))
