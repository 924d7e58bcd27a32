"""A kept latched message comes back with its node."""

from __future__ import annotations

import pytest
import rclpy
from mbd_bag.storage.definitions import full_definition
from mbd_model.ros.kept_messages import ADDED, kept_message
from mbd_model.ros.latch import LatchedPublisher
from mbd_msgs.msg import Assist, Assists, Denial, Progress, Prompt, SessionState, Task, TaskStep
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


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


ASSIST = Assist(source_id="s1", target_id="t1", step_index=1, kind=1)
KEPT = {
    "state": SessionState(session="abc", phase=5, detail="recording"),
    "state of another length": SessionState(session="abcd", phase=5, assists=[ASSIST, ASSIST], num_events=1),
    "assists": Assists(session="s", assists=[ASSIST]),
    "prompt": Prompt(kind=2, text="What do I use now?", step_index=1, source_id="s1"),
    "progress": Progress(session="ab", text="places t1 onto t2", step_statuses=[1, 2, 3]),
    "task": Task(steps=[TaskStep(index=0)], problems=["it ended with s1 in the hand"]),
    "task without problems": Task(steps=[TaskStep(index=0)]),
}


def as_kept_by(version: str, message: object) -> bytes:
    """Its CDR bytes by the definitions of a version: those of today without what was added since."""
    store = get_typestore(Stores.EMPTY)
    kind = f"mbd_msgs/msg/{type(message).__name__}"
    store.register(get_types_from_msg(full_definition(kind), kind))
    value = store.deserialize_cdr(bytes(serialize_message(message)), kind)
    since = {"0.1.0": ("0.3.0", "0.2.0"), "0.2.0": ("0.3.0",)}[version]
    for lacking in (pair for later in since for pair in ADDED[later]):
        full = f"mbd_msgs/msg/{lacking[0]}"
        if full in store.fielddefs:
            constants, fields = store.fielddefs[full]
            store.fielddefs[full] = (constants, [f for f in fields if f[0] != lacking[1]])
    old = get_typestore(Stores.EMPTY)
    old.register(dict(store.fielddefs))
    return bytes(old.serialize_cdr(value, kind))


@pytest.mark.parametrize("version", ["0.1.0", "0.2.0"])
@pytest.mark.parametrize("name", KEPT)
def test_what_an_older_version_kept_is_read_with_defaults_for_the_fields_it_lacked(name: str, version: str):
    assert kept_message(as_kept_by(version, KEPT[name]), type(KEPT[name])) == KEPT[name]


@pytest.mark.parametrize("name", KEPT)
def test_what_this_version_keeps_is_read_as_it_was_with_every_field(name: str):
    message = KEPT[name]
    if isinstance(message, SessionState):
        denial = Denial(source_id="s1", target_id="t2")
        confirmed = Assist(source_id="s2", target_id="t1", confirmed=True)
        message = SessionState(session="a", assists=[confirmed], denials=[denial], skipped=[3, 5], recording=True)
    assert kept_message(bytes(serialize_message(message)), type(message)) == message


@pytest.mark.parametrize("name", KEPT)
def test_a_kept_message_cut_off_is_none_or_what_an_older_version_would_have_kept(name: str):
    message = KEPT[name]
    data = bytes(serialize_message(message))
    for cut in range(1, len(data)):
        try:
            read = kept_message(data[:-cut], type(message))
        except RuntimeError:
            continue
        assert read == message, f"{cut} bytes short"


def test_a_list_cut_off_within_the_added_fields_is_none():
    data = bytes(serialize_message(Task(problems=["one", "two"], open_ends=[1, 0, 1])))
    for cut in {*range(1, 20)} - {4}:  # without its last list, the doubts, it is what version 0.2.0 kept
        with pytest.raises(RuntimeError):
            kept_message(data[:-cut], Task)


def test_a_forgotten_message_does_not_come_back(node, tmp_path):
    latch = LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path))
    latch.publish(SessionState(session="a"))
    latch.forget()
    assert LatchedPublisher(node, SessionState, "interaction/state", str(tmp_path)).last is None
