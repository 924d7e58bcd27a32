"""A recording ends with its session, and what people say after it is recorded all the same."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import pytest
import rclpy
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.recorder.session_span import SessionSpan
from mbd_bag.storage.bag import Bag
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_model.session import Phase
from mbd_msgs.msg import SessionState, WizardNote
from rclpy.node import Node
from sensor_msgs.msg import Image

RUNNING = [p for p in Phase if p not in (Phase.DONE, Phase.ABORTED)]


@given(st.lists(st.sampled_from(RUNNING), min_size=1), st.floats(0.0, 1e6))
def test_a_session_that_runs_is_recorded_whatever_comes_and_however_long_it_is_silent(phases, later: float):
    span = SessionSpan(follows=True)
    for phase in phases:
        span.enter(phase, 0.0)
        assert span.keeps("/camera/color/image_raw", later)
        assert not span.closes(later)


@pytest.mark.parametrize("end", [Phase.DONE, Phase.ABORTED])
def test_after_the_end_only_people_are_recorded_and_their_last_word_closes_the_bag(end: Phase):
    span = SessionSpan(follows=True)
    span.enter(end, 10.0)
    assert span.keeps("/cell/truth", 11.0)
    assert not span.closes(11.0)
    assert span.closes(12.0)
    assert not span.keeps("/cell/truth", 12.5)
    assert span.keeps("/lab/wizard/note", 20.0)
    assert not span.closes(21.0)
    assert span.closes(22.0)
    span.enter(Phase.EXECUTE, 30.0)
    assert span.keeps("/joint_states", 40.0)
    assert not span.closes(99.0)


def test_a_recorder_that_was_not_asked_to_end_with_the_session_does_not():
    span = SessionSpan(follows=False)
    span.enter(Phase.DONE, 0.0)
    assert span.keeps("/joint_states", 99.0)
    assert not span.closes(99.0)


def wait_for(happened: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + 60.0
    while not happened():
        assert time.monotonic() < deadline, f"waited 60 s for {what}"
        time.sleep(0.02)


@pytest.mark.node
def test_the_bag_is_closed_at_done_and_a_later_note_is_in_its_next_file(ros_domain: int, tmp_path: Path, recorders):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = Node("session", context=context)
    state = node.create_publisher(SessionState, "interaction/state", LATCHED)
    notes = node.create_publisher(WizardNote, "wizard/note", EVENTS)
    images = node.create_publisher(Image, "camera/color/image_raw", SENSOR)
    folder = tmp_path / "bag"
    words = (f"bag:={folder}", "min_free:=1.0", "end_with_session:=true", "plan:=[condition=mbd, deviation=a lamp]")
    recorder = recorders.start(ros_domain, "--ros-args", *(w for p in words for w in ("-p", p)))

    def listens() -> bool:
        return all(p.get_subscription_count() for p in (state, notes, images))

    def closed_after(files: int) -> bool:
        return (folder / "metadata.yaml").exists() and len(list(folder.glob("*.mcap"))) == files

    wait_for(listens, "the recorder")
    state.publish(SessionState(phase=SessionState.ASSIST))
    state.publish(SessionState(phase=SessionState.DONE))
    wait_for(lambda: closed_after(1), "the bag to be closed")
    # What goes on by itself opens nothing: neither pictures nor the end stated again.
    images.publish(Image())
    state.publish(SessionState(phase=SessionState.DONE))
    assert recorder.poll() is None
    notes.publish(WizardNote(text="the lamp broke"))
    wait_for(lambda: closed_after(2), "the bag to be closed again")
    recorder.send_signal(2)
    assert recorder.wait() == 0
    bag = Bag(folder)
    assert [m.phase for _, m in bag.decoded({"/interaction/state"})] == [SessionState.ASSIST, SessionState.DONE]
    assert [m.text for _, m in bag.decoded({"/wizard/note"})] == ["the lamp broke"]
    assert not [t for t in bag.topics if t.name.startswith("/camera") and t.count]
    assert (bag.facts["plan.condition"], bag.facts["plan.deviation"]) == ("mbd", "a lamp")
    node.destroy_node()
    rclpy.try_shutdown(context=context)
