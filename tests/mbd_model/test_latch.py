"""A kept latched message comes back with its node."""

from __future__ import annotations

import pytest
import rclpy
from mbd_model.ros.kept_messages import kept_message
from mbd_model.ros.latch import LatchedPublisher
from mbd_msgs.msg import Assist, Progress, SessionState, Task, TaskStep
from rclpy.serialization import serialize_message


@pytest.fixture
def node(ros_domain: int):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("latch_test", context=context)
    yield node
    node.destroy_node()
    rclpy.try_shutdown(context=context)


def test_the_last_message_is_restored_and_published_again(node, tmp_path):
    LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path)).publish(SessionState(session="a", phase=5))
    again = LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path))
    assert again.last == SessionState(session="a", phase=5)


def test_without_a_state_folder_nothing_is_kept(node, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    LatchedPublisher(node, SessionState, "interaction/state").publish(SessionState(session="a"))
    assert LatchedPublisher(node, SessionState, "interaction/state").last is None
    assert not list(tmp_path.iterdir())


def test_a_broken_file_is_set_aside_not_fatal(node, tmp_path):
    (tmp_path / "interaction.state.cdr").write_bytes(b"garbage")
    assert LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path)).last is None
    assert (tmp_path / "interaction.state.broken").read_bytes() == b"garbage"


# What version 0.1.0 kept, whose messages lacked the last fields of today's: their bytes there, whatever precedes them.
OLD = {
    "state": (SessionState(session="abc", phase=5, detail="recording"), 2),
    "state of another length": (SessionState(session="abcd", phase=5, assists=[Assist(step_index=1)]), 2),
    "progress": (Progress(session="ab", text="places t1 onto t2", step_statuses=[1, 2, 3]), 17),
    "task": (Task(steps=[TaskStep(index=0)], problems=["it ended with s1 in the hand"]), 7),
    "task without problems": (Task(steps=[TaskStep(index=0)]), 4),
}


@pytest.mark.parametrize("name", OLD)
def test_what_an_older_version_kept_is_read_with_defaults_for_the_fields_it_lacked(name):
    message, lacking = OLD[name]
    data = bytes(serialize_message(message))
    assert kept_message(data[:-lacking], type(message)) == message


@pytest.mark.parametrize("name", OLD)
def test_a_kept_message_cut_off_anywhere_else_is_none(name):
    message, lacking = OLD[name]
    data = bytes(serialize_message(message))
    for cut in {*range(1, len(data))} - {lacking}:
        try:
            read = kept_message(data[:-cut], type(message))
        except RuntimeError:
            continue
        assert read == message and abs(cut - lacking) < 4, f"{cut} bytes short"  # only padding differs


def test_a_list_cut_off_within_the_added_fields_is_none():
    data = bytes(serialize_message(Task(problems=["one", "two"], open_ends=[1, 0, 1])))
    for cut in range(1, 16):
        with pytest.raises(RuntimeError):
            kept_message(data[:-cut], Task)


def test_a_forgotten_message_does_not_come_back(node, tmp_path):
    latch = LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path))
    latch.publish(SessionState(session="a"))
    latch.forget()
    assert LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path)).last is None
