"""What bags recorded before the typed session state left out is derived from what they state."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.upgrading import upgrade, upgraded_bytes
from mbd_model.ros.conversions import task_from_msg
from mbd_model.session import Awaited, Phase, PromptKind, SessionState
from mbd_msgs import msg as m
from rclpy.serialization import deserialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

BAGS = Path(__file__).resolve().parents[2] / "bags"
NAMES = sorted(p.parent.name for p in BAGS.glob("*/metadata.yaml"))
OF_KIND = {PromptKind.WHAT_DO_I_USE: Awaited.HANDED, PromptKind.WHERE_DO_I_GO: Awaited.POINTED}
HEADER = "std_msgs/Header header\n"


@pytest.fixture(params=NAMES)
def old(request: pytest.FixtureRequest) -> RecordedSession:
    return session_from_bag(Bag(BAGS / request.param))


def test_nothing_of_the_session_is_reported_as_missing(old: RecordedSession):
    assert not [p for p in old.problems if "older version" in p]


def test_a_recording_is_from_the_teacher_s_start_to_the_phase_s_end(old: RecordedSession):
    """Of these sessions none repeats its demonstration: in DEMONSTRATE first nothing is recorded, then all the time."""
    states = [s.value for s in old.states]
    demonstrating = [s.recording for s in states if s.phase is Phase.DEMONSTRATE]
    assert True in demonstrating and demonstrating == sorted(demonstrating)
    assert not any(s.recording for s in states if s.phase is not Phase.DEMONSTRATE)


def test_what_was_asked_is_awaited_as_the_prompt_of_that_moment_asked_it(old: RecordedSession):
    asked = [s for s in old.states if s.value.phase is Phase.ASSIST and s.value.step_index >= 0]
    assert bool(asked) == any(p.value.kind in OF_KIND for p in old.prompts)  # one session was confident at once
    for state in asked:
        prompts = [p.value for p in old.prompts if p.value.step_index == state.value.step_index]
        assert {OF_KIND[p.kind] for p in prompts} == {state.value.awaiting}


def test_only_the_end_of_an_execution_is_unknown(old: RecordedSession):
    for state in (s.value for s in old.states):
        assert (state.awaiting is Awaited.UNKNOWN) == (state.phase is Phase.EXECUTE)
        assert (state.awaiting is Awaited.NOTHING) == (state.phase in (Phase.DONE, Phase.ABORTED))


def test_between_two_questions_the_estimate_is_awaited(old: RecordedSession):
    states = [s.value for s in old.states]
    for before, after in pairwise(states):
        if is_question(after) and before.phase is Phase.ASSIST and not is_question(before):
            assert before.awaiting in (Awaited.ESTIMATE, Awaited.TASK)


def is_question(state: SessionState) -> bool:
    return state.phase is Phase.ASSIST and state.step_index >= 0


def old_store(kind: str, definition: str) -> object:
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(definition, kind))
    return store


def empty_header(store: object) -> object:
    time = store.types["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    return store.types["std_msgs/msg/Header"](stamp=time, frame_id="")


@pytest.mark.parametrize("paused", [False, True])
def test_an_old_state_is_played_to_today_s_nodes_with_what_it_did_not_state(paused: bool):
    kind = "mbd_msgs/msg/SessionState"
    store = old_store(kind, f"{HEADER}string session\nuint8 phase\nbool paused\nstring detail\n")
    detail = "I am watching. Please guide my arm through the task."
    state = store.types[kind](
        header=empty_header(store), session="s", phase=int(Phase.DEMONSTRATE), paused=paused, detail=detail
    )
    played = deserialize_message(upgraded_bytes(bytes(store.serialize_cdr(state, kind)), kind, store), m.SessionState)
    assert played.recording
    assert Awaited(played.awaiting) is (Awaited.RESUME if paused else Awaited.DEMONSTRATION_STOP)


def test_an_old_task_shows_which_of_its_problems_only_report_how_it_ended():
    kind = "mbd_msgs/msg/Task"
    today = Bag(BAGS / "stacking").decoder.store(kind)
    assert "open_ends" not in dict(today.fielddefs[kind][1])
    ended = "the demonstration ended while holding 's1': its last pick has no place"
    scene = next(msg for _, msg in Bag(BAGS / "stacking").decoded({"/perception/source_scene"}))
    task = today.types[kind](header=scene.header, source=scene, steps=[], problems=["at 1.0 s the hand closed", ended])
    assert task_from_msg(upgrade(task, kind, today)).open_ends == (1,)
    again = deserialize_message(upgraded_bytes(bytes(today.serialize_cdr(task, kind)), kind, today), m.Task)
    assert np.array_equal(again.open_ends, [1])
