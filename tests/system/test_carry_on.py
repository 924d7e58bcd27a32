"""A whole session of separate processes in which the robot carries on alone, is corrected, and ends rightly."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from mbd_bringup.follow_node import Happening
from mbd_bringup.live_node import LiveSession
from mbd_bringup.nodes import SessionOptions
from mbd_cell.outcome import PlaceOutcome
from mbd_model.qos import EVENTS
from mbd_model.session import Phase
from mbd_msgs.msg import WizardCommand, WizardOverwrite

pytestmark = pytest.mark.timeout(600)


def carried_on(
    folder: Path, watch: Callable[[LiveSession, Happening], None], task: str = "lunch_packing"
) -> tuple[list[Happening], tuple[PlaceOutcome, ...]]:
    """Run a session to its end; what happened, and what became of each place step."""
    heard = []
    options = SessionOptions("alone", folder, task=task, seed=2, speed=0.0, carry_on=True)
    with LiveSession(options) as live:
        for happening in live.happenings(timeout=400):
            if happening is not None:
                heard.append(happening)
                watch(live, happening)
        assert live.phase is Phase.DONE
        assert live.processes.stop(patience=20) == []
    return heard, live.follower.ending.places()


def test_the_objects_of_a_session_end_where_they_should(tmp_path: Path):
    heard, places = carried_on(tmp_path / "session", lambda live, happening: None)
    assert [p.success for p in places] == [True, True, True], places
    said = [h.text for h in heard if h.speaker == "arm"]
    assert said[-1] == "the task is done"
    assert [t[:6] for t in said[:-1]] == [f"step {k}" for k in range(1, 7)]


def test_a_correction_while_the_robot_carries_stops_it_and_it_does_the_right_thing_in_the_end(tmp_path: Path):
    sent: list[str] = []
    given: dict[str, str] = {}

    def correct(live: LiveSession, happening: Happening) -> None:
        """At step 2 the wizard says a wrong object, and at once the right one again."""
        if happening.speaker != "arm" or "step 2" not in happening.text or sent:
            return
        publisher = live.follower.create_publisher(WizardOverwrite, "wizard/overwrite", EVENTS)
        while not publisher.get_subscription_count():
            pass
        right = happening.text.split("set ")[1].split()[0]
        other = next(t for t in ("t1", "t2", "t3", "t4") if t not in happening.text)
        given.update(right=right, other=other)
        publisher.publish(WizardOverwrite(step_index=0, object_id=other))
        sent.append(other)

    def correct_back(live: LiveSession, happening: Happening) -> None:
        correct(live, happening)
        if sent and len(sent) == 1 and "put back" in happening.text:
            publisher = live.follower.create_publisher(WizardOverwrite, "wizard/overwrite", EVENTS)
            while not publisher.get_subscription_count():
                pass
            publisher.publish(WizardOverwrite(step_index=0, object_id=given["right"]))
            sent.append(given["right"])

    heard, places = carried_on(tmp_path / "session", correct_back)
    texts = [h.text for h in heard]
    assert len(sent) == 2, texts
    assert any(t.startswith(f"put back {given['right']}") for t in texts)
    assert [p.success for p in places] == [True, True, True], (places, texts)


def test_a_carry_on_node_killed_amid_the_work_goes_on_where_it_was(tmp_path: Path):
    killed: list[str] = []

    def kill(live: LiveSession, happening: Happening) -> None:
        if happening.speaker == "arm" and "step 3" in happening.text and not killed:
            live.processes.restart("carry_on")
            killed.append(happening.text)

    heard, places = carried_on(tmp_path / "session", kill)
    assert killed
    assert [p.success for p in places] == [True, True, True], (places, [h.text for h in heard])


def test_a_paused_robot_stands_still_and_goes_on_when_resumed(tmp_path: Path):
    done: list[int] = []

    def pause(live: LiveSession, happening: Happening) -> None:
        if happening.speaker == "arm" and "step 2" in happening.text and not done:
            publisher = live.follower.create_publisher(WizardCommand, "wizard/command", EVENTS)
            while not publisher.get_subscription_count():
                pass
            publisher.publish(WizardCommand(command=WizardCommand.PAUSE))
            done.append(1)
        if done == [1] and happening.speaker == "wizard" and happening.text.endswith("paused"):
            publisher = live.follower.create_publisher(WizardCommand, "wizard/command", EVENTS)
            while not publisher.get_subscription_count():
                pass
            publisher.publish(WizardCommand(command=WizardCommand.RESUME))
            done.append(2)

    _, places = carried_on(tmp_path / "session", pause)
    assert done == [1, 2]
    assert [p.success for p in places] == [True, True, True], places
