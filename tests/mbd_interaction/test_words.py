"""Each wizard word by service and by the command ``say``: answered, and received by all who subscribe to its topic."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable

import pytest
import rclpy
from geometry_msgs.msg import Point
from mbd_interaction.ros.conversions import WIZARD_TOPICS
from mbd_interaction.ros.say import MISUSED, REFUSED, UNSAID, request_of, say
from mbd_interaction.words import STOP, WORDS, word_named
from mbd_model.errors import MbdError
from mbd_model.ros.qos import EVENTS
from mbd_model.ros.stop_line import StopLine
from mbd_model.ros.word_check import WordCheck
from mbd_model.session import Phase
from mbd_msgs import msg as m
from mbd_msgs.srv import Say
from rclpy.executors import SingleThreadedExecutor


def test_every_value_of_every_wizard_topic_has_its_word():
    for topic, (kind, _) in WIZARD_TOPICS.items():
        codes = {w.code for w in WORDS.values() if w.topic == topic}
        coded = {"command", "answer"} & set(kind.get_fields_and_field_types())
        named = {v for k, v in vars(type(kind)).items() if k.isupper() and isinstance(v, int)}
        constants = {getattr(kind, name) for name in dir(type(kind)) if name.isupper()} | named
        assert codes == ({c for c in constants if isinstance(c, int)} if coded else {0}), topic


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("handed", "expected the id of one object"),
        ("handed t1 t2", "expected the id of one object"),
        ("pointed 0.5 x 0.1", "'x' is no number; expected metres"),
        ("undo twice", "'twice' is one word too many"),
        ("overwrite t3", "expected the step"),
        ("overwrite -1 t3", "counted from 0"),
        ("revise delete", "expected one of delete"),
        ("revise move 2", "the step to go to"),
        ("revise delete 2 3", "takes nothing after the step"),
        ("note", "expected the text"),
        ("hand t3", "there is no word 'hand'; did you mean 'handed'"),
    ],
)
def test_what_is_no_word_is_refused_with_what_would_be(line: str, reason: str):
    name, *given = line.split()
    with pytest.raises(MbdError, match=reason):
        word_named(name).parse(given)


def test_what_a_word_does_not_take_is_refused_under_its_name_and_with_what_it_takes():
    for name, reason in (("handed", "^handed OBJECT: expected the id"), ("note", "^note TEXT: expected the text")):
        with pytest.raises(MbdError, match=reason):
            say(name, [], 0.0)


def test_arguments_become_what_the_service_takes():
    assert request_of(word_named("pointed").parse(["0.5", "0.41", "0.05"])).place == Point(x=0.5, y=0.41, z=0.05)
    revised = request_of(word_named("revise").parse(["split", "2", "12.5"]))
    assert (revised.step_index, revised.at.sec, revised.at.nanosec) == (2, 12, 500_000_000)
    assert request_of(word_named("note").parse(["may", "be", "full"])).text == "may be full"


Called = Callable[..., Say.Response]


@pytest.fixture
def call(session) -> Called:
    """Says a word by its service, as somebody who has just come."""

    def called(name: str, *given: str) -> Say.Response:
        node = rclpy.create_node("caller", context=session.context)
        session.executor.add_node(node)
        try:
            client = node.create_client(Say, f"wizard/{name}")
            session.until(client.service_is_ready)
            future = client.call_async(request_of(word_named(name).parse(given)))
            session.until(future.done)
            return future.result()
        finally:
            session.executor.remove_node(node)
            node.destroy_node()

    return called


def test_a_session_is_led_by_services_alone_and_every_listener_hears_every_word(session, call: Called):
    received: list[str] = []
    for topic, (kind, _) in WIZARD_TOPICS.items():
        session.peer.create_subscription(kind, topic, lambda _, topic=topic: received.append(topic), EVENTS)
    session.until(lambda: all(session.node.count_subscribers(topic) > 1 for topic in WIZARD_TOPICS))
    said = ["next_phase", "start_demonstration", "close", "open", "stop_demonstration", "next_phase", "next_phase"]
    for number, name in enumerate(said, start=1):
        answer = call(name)
        assert answer.success and answer.sequence == number, answer.message
    session.until(lambda: session.phase is Phase.ASSIST and bool(session.received["assists"]))
    session.infer(0.0)
    session.until(lambda: session.received["prompt"][-1].kind == m.Prompt.WHAT_DO_I_USE)
    refused = call("handed", "t99")
    assert not refused.success and "unknown object 't99'" in refused.message
    assert call("handed", "t1").success
    assert call("note", "half", "full").success
    session.until(lambda: len(received) == len(said) + 3)
    assert received == [WORDS[name].topic for name in (*said, "handed", "handed", "note")]
    replies = session.received["replies"]
    session.until(lambda: len(replies) == len(received))
    assert [r.sequence for r in replies] == list(range(1, len(received) + 1))
    assert [r.heard for r in replies if r.topic == "wizard/gripper"] == [1, 2]


def test_a_word_that_missed_a_node_is_noticed_there_and_one_that_it_received_is_not(session, call: Called):
    """The peer listens to the replies, and to the gripper's words only at first."""
    check = WordCheck(session.peer, "wizard/gripper")
    listening = session.peer.create_subscription(m.WizardGripper, "wizard/gripper", lambda _: check.count(), EVENTS)
    session.until(lambda: session.node.count_subscribers("wizard/gripper") > 1)
    session.until(lambda: session.node.count_subscribers("interaction/replies") > 1)
    call("close")
    call("open")
    session.until(lambda: check._mine == 2 and check._theirs == 2)
    for _ in range(10):
        check._look()
    assert check.missed == 0
    session.peer.destroy_subscription(listening)
    call("close")
    session.until(lambda: check.missed == 1)


@pytest.fixture
def spinning(session):
    """The session in a thread of its own, so that processes find it."""
    done = threading.Event()

    def spin(executor: SingleThreadedExecutor) -> None:
        while not done.is_set():
            executor.spin_once(timeout_sec=0.02)

    thread = threading.Thread(target=spin, args=(session.executor,))
    thread.start()
    yield session
    done.set()
    thread.join()


def said(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mbd_interaction.ros.say", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, env=dict(os.environ), check=False)


def test_the_command_prints_the_answer_and_its_exit_code_states_what_became_of_the_word(spinning, ros_domain: int):
    line = StopLine(spinning.peer)
    os.environ["ROS_DOMAIN_ID"] = str(ros_domain)
    noted = said("note", "the cups may be full")
    assert (noted.returncode, noted.stdout.strip()) == (0, "noted"), noted.stderr
    refused = said("handed", "t3")
    assert refused.returncode == REFUSED and "refused: 'handed' is not for phase" in refused.stderr
    stopped = said(STOP)
    assert stopped.returncode == 0 and line.latch.held, stopped.stderr


def test_a_mistake_is_one_sentence_and_nobody_there_too(ros_domain: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(ros_domain))
    wrong = said("hand", "t3")
    assert wrong.returncode == MISUSED and wrong.stderr.startswith("say: there is no word 'hand'")
    alone = said("--wait", "0.3", "undo")
    assert alone.returncode == UNSAID and alone.stderr.startswith("say: nobody serves 'wizard/undo'")
    assert alone.stderr.count("\n") == 1
