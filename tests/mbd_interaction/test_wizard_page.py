"""The commands of docs/wizard.md do what the page states: sent in its order, they are one session."""

from __future__ import annotations

import importlib
import shlex
from pathlib import Path

import pytest
import yaml
from mbd_interaction.ros.conversions import WIZARD_TOPICS
from mbd_model.ros.qos import EVENTS
from mbd_model.session import Phase

PAGE = Path(__file__).resolve().parents[2] / "docs" / "wizard.md"
SESSION = PAGE.read_text(encoding="utf-8").partition("## The session")[2]
COMMANDS = [line for line in SESSION.splitlines() if line.startswith("ros2 topic pub ")]


def parsed(command: str) -> tuple[str, type, dict]:
    """(topic, message type, its fields) of one command, as the ros2 tool reads it."""
    _, _, _, *options, topic, kind, fields = shlex.split(command)
    # Without these it leaves before it has found every listener.
    assert options == ["-1", "-w", "2", "--keep-alive", "3"]
    package, _, name = kind.split("/")
    return topic, getattr(importlib.import_module(f"{package}.msg"), name), yaml.safe_load(fields)


def filled(message: object, fields: dict) -> object:
    """The message with its fields set; a field it does not have fails, as the ros2 tool does."""
    for name, value in fields.items():
        here = getattr(message, name)
        setattr(message, name, filled(here, value) if isinstance(value, dict) else type(here)(value))
    return message


def test_the_page_has_an_example_for_every_wizard_topic():
    assert {parsed(c)[0].lstrip("/") for c in COMMANDS} == set(WIZARD_TOPICS)


def test_every_command_of_every_command_topic_is_shown():
    shown = {(topic, fields.get("command")) for topic, _, fields in map(parsed, COMMANDS)}
    assert {c for t, c in shown if t == "/wizard/command"} == set(range(1, 9))
    answers = {fields.get("answer") for topic, _, fields in map(parsed, COMMANDS) if topic == "/wizard/answer"}
    assert answers == {1, 2}
    assert {c for t, c in shown if t in ("/wizard/gripper",)} == {1, 2}
    assert {c for t, c in shown if t in ("/wizard/demonstration",)} == {1, 2}


def test_sent_in_order_each_is_accepted_and_the_session_ends(session):
    publishers = {}
    for topic, kind, _ in map(parsed, COMMANDS):
        publishers.setdefault(topic, session.peer.create_publisher(kind, topic, EVENTS))
    session.until(lambda: all(p.get_subscription_count() for p in publishers.values()))
    phases = []
    for command in COMMANDS:
        topic, kind, fields = parsed(command)
        before = len(session.received["replies"])
        publishers[topic].publish(filled(kind(), fields))
        session.until(lambda n=before: len(session.received["replies"]) > n)
        reply = session.received["replies"][-1]
        assert reply.accepted, f"{command}: {reply.reason}"
        settle(session)
        phases.append(session.phase)
    assert phases[-1] is Phase.ABORTED
    assert set(phases) == set(Phase) - {Phase.OBSERVE_SOURCE}


def settle(session) -> None:
    """Let the mapping answer, never confidently, whatever list of assists is in force."""
    session.catch_up()
    if session.phase is Phase.ASSIST and session.received["state"][-1].step_index < 0:
        session.infer(0.0)
        session.until(lambda: session.received["state"][-1].step_index >= 0 or session.phase is not Phase.ASSIST)


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_publishes_under_another_type(command: str):
    topic, kind, _ = parsed(command)
    assert WIZARD_TOPICS[topic.lstrip("/")][0] is kind
