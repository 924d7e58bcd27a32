"""A kept latched message comes back with its node."""

from __future__ import annotations

import pytest
import rclpy
from mbd_model.ros.latch import LatchedPublisher
from mbd_msgs.msg import SessionState


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


def test_a_forgotten_message_does_not_come_back(node, tmp_path):
    latch = LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path))
    latch.publish(SessionState(session="a"))
    latch.forget()
    assert LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path)).last is None
