"""A complete session of separate processes: the robot at work is corrected, paused and killed, and ends rightly."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from mbd_bag.session.recorded_session import RecordedReply
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.follow import SessionEvent
from mbd_bringup.ros.live_session import LiveSession
from mbd_cell.outcome import PlaceOutcome
from mbd_model.execution_progress import Progress, Purpose, Status
from mbd_model.ros.qos import EVENTS
from mbd_model.session import Phase
from mbd_msgs.msg import WizardCommand, WizardOverwrite

pytestmark = pytest.mark.timeout(900)


class Operator:
    """Somebody beside the scripted wizard, who states a few things to the session."""

    def __init__(self, live: LiveSession) -> None:
        self.live = live
        self.sent: list[WizardCommand | WizardOverwrite] = []
        self._out = {
            WizardCommand: live.follower.create_publisher(WizardCommand, "wizard/command", EVENTS),
            WizardOverwrite: live.follower.create_publisher(WizardOverwrite, "wizard/overwrite", EVENTS),
        }

    def send(self, msg: WizardCommand | WizardOverwrite) -> None:
        """Publish it once the dialogue listens."""
        end = time.monotonic() + 60
        while not self._out[type(msg)].get_subscription_count():
            assert time.monotonic() < end, "nobody listens to the operator"
            time.sleep(0.01)
        self._out[type(msg)].publish(msg)
        self.sent.append(msg)


Watch = Callable[[Operator, SessionEvent], None]


def executed(folder: Path, watch: Watch) -> tuple[Operator, list[SessionEvent], tuple[PlaceOutcome, ...]]:
    """Run a session to its end; who watched it, what happened, and what became of each place step."""
    received = []
    options = SessionOptions("alone", folder, task="lunch_packing", seed=2, speed=0.0, execute=True)
    with LiveSession(options) as live:
        operator = Operator(live)
        for event in live.events(timeout=600):
            if event is not None:
                received.append(event)
                watch(operator, event)
        assert live.phase is Phase.DONE
        assert live.processes.stop(patience=60) == []
    return operator, received, live.follower.ending.places()


def at_step(event: SessionEvent, step: int) -> bool:
    """Whether the arm is at a step, counted from 1, or past it: of a latched topic only the last message is sure."""
    now = event.fact
    return isinstance(now, Progress) and now.purpose in (Purpose.PICK, Purpose.PLACE) and now.step_index >= step - 1


@dataclass(frozen=True)
class Interrupted:
    """A session corrected at step 2, paused and resumed at step 4, whose execution node was killed at step 5."""

    right: str
    sent: list[WizardCommand | WizardOverwrite]
    killed_at: list[str]
    received: list[SessionEvent]
    places: tuple[PlaceOutcome, ...]

    @property
    def progress(self) -> list[Progress]:
        return [h.fact for h in self.received if isinstance(h.fact, Progress)]


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory: pytest.TempPathFactory) -> Interrupted:
    right: list[str] = []
    killed: list[str] = []

    def interrupt(operator: Operator, event: SessionEvent) -> None:
        """At step 2 the wizard states a wrong object and, once the right one was put back, the right one again."""
        if at_step(event, 2) and not operator.sent:
            used = (event.fact.object_id, event.fact.receiver_id)
            right.append(used[0])
            wrong = next(t for t in ("t1", "t2", "t3", "t4") if t not in used)
            operator.send(WizardOverwrite(step_index=0, object_id=wrong))
        if len(operator.sent) == 1 and isinstance(event.fact, Progress) and event.fact.purpose is Purpose.RETURN:
            operator.send(WizardOverwrite(step_index=0, object_id=right[0]))
        if at_step(event, 4) and len(operator.sent) == 2:
            operator.send(WizardCommand(command=WizardCommand.PAUSE))
        reply = event.fact if isinstance(event.fact, RecordedReply) and event.fact.accepted else None
        if len(operator.sent) == 3 and reply is not None and reply.topic.endswith("wizard/command"):
            operator.send(WizardCommand(command=WizardCommand.RESUME))
        if at_step(event, 5) and not killed:
            operator.live.processes.restart("execution")
            killed.append(event.text)

    operator, received, places = executed(tmp_path_factory.mktemp("interrupted") / "session", interrupt)
    return Interrupted(right[0], operator.sent, killed, received, places)


def test_a_correction_during_execution_stops_it_and_it_does_the_right_thing_in_the_end(interrupted: Interrupted):
    assert [type(m) for m in interrupted.sent[:2]] == [WizardOverwrite, WizardOverwrite]
    returned = [p.object_id for p in interrupted.progress if p.purpose is Purpose.RETURN]
    assert interrupted.right in returned
    assert [p.success for p in interrupted.places] == [True, True, True], interrupted.places


def test_a_session_paused_amid_the_work_goes_on_when_resumed_and_its_objects_end_where_they_should(
    interrupted: Interrupted,
):
    commands = [m.command for m in interrupted.sent if isinstance(m, WizardCommand)]
    assert commands == [WizardCommand.PAUSE, WizardCommand.RESUME]
    assert [p.success for p in interrupted.places] == [True, True, True], interrupted.places
    assert interrupted.progress[-1].status is Status.FINISHED
    steps = [p.step_index for p in interrupted.progress if p.purpose in (Purpose.PICK, Purpose.PLACE)]
    assert list(dict.fromkeys(steps)) == list(range(6))


def test_an_execution_node_killed_amid_the_work_goes_on_where_it_was(interrupted: Interrupted):
    assert interrupted.killed_at
    texts = [h.text for h in interrupted.received]
    assert [p.success for p in interrupted.places] == [True, True, True], (interrupted.places, texts)
