"""The follower reports what happens by the facts it receives, not by their sentences."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from mbd_bag.session.recorded_session import RecordedReply
from mbd_bringup.ros.follow import SessionEvent, SessionFollower
from mbd_interaction.synthetic import stacking_task
from mbd_model.estimate import Mapping, MappingEstimate
from mbd_model.execution_progress import Progress, Purpose, Status
from mbd_model.ros import conversions
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import Task
from mbd_msgs import msg as m
from rclpy.executors import SingleThreadedExecutor
from rewording import REWORDINGS, Rewording, reworded, without_sentences

QOS = {
    "interaction/state": (m.SessionState, LATCHED),
    "interaction/prompt": (m.Prompt, LATCHED),
    "interaction/replies": (m.WizardReply, EVENTS),
    "interaction/progress": (m.Progress, LATCHED),
    "demonstration/task": (m.Task, LATCHED),
    "mapping/estimate": (m.MappingEstimate, LATCHED),
}
ZERO = conversions.time_to_msg(0.0)
ESTIMATE = MappingEstimate("mbd", Mapping((("s1", "t1"),)), 0.3, warnings=("an assist was left out",), num_assists=1)


def at_work(purpose: Purpose, step: int, status: Status = Status.UNDER_WAY) -> m.Progress:
    now = Progress(step, status, f"step {step + 1}: {purpose.words} t1", (), purpose, "t1")
    return conversions.progress_to_msg(now, "s", ZERO)


# What is published, and whether the follower reports it.
COURSE: list[tuple[str, Any, bool]] = [
    ("interaction/state", conversions.state_to_msg(SessionState("s", Phase.ASSIST, detail="now"), 1.0), True),
    ("interaction/state", conversions.state_to_msg(SessionState("s", Phase.ASSIST, detail="paused"), 1.0), False),
    ("demonstration/task", conversions.task_to_msg(stacking_task(3)), True),
    ("interaction/prompt", conversions.prompt_to_msg(Prompt(PromptKind.WHAT_DO_I_USE, "What?", 2, "s1"), 1.0), True),
    ("interaction/replies", m.WizardReply(topic="wizard/handed", accepted=False, reason="no such object"), True),
    ("interaction/replies", m.WizardReply(topic="wizard/handed", accepted=True, reason="s1 is t1"), True),
    ("mapping/estimate", conversions.estimate_to_msg(ESTIMATE, session="s", threshold=0.02, stamps=(ZERO,) * 3), True),
    ("interaction/progress", at_work(Purpose.PICK, 0), True),
    ("interaction/progress", at_work(Purpose.PICK, 0), False),
    ("interaction/progress", at_work(Purpose.RETURN, 0), True),
    ("interaction/progress", at_work(Purpose.NONE, -1, Status.FINISHED), True),
]
FACTS = (SessionState, Task, Prompt, RecordedReply, RecordedReply, MappingEstimate, Progress, Progress, Progress)


class Followed:
    """A follower and, beside it, what publishes to it."""

    def __init__(self, domain: int) -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._follower = SessionFollower(context=self._context)
        self._peer = rclpy.create_node("peer", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._follower)
        self._executor.add_node(self._peer)
        self._out = {topic: self._peer.create_publisher(kind, topic, qos) for topic, (kind, qos) in QOS.items()}
        end = time.monotonic() + 60
        while not all(p.get_subscription_count() for p in self._out.values()):
            assert time.monotonic() < end, "the follower does not listen"
            self._executor.spin_once(timeout_sec=0.02)

    def prints(self, topic: str, msg: Any, *, something: bool) -> list[SessionEvent]:
        """What it prints of a message; waits until it prints something, else until it has received a later message."""
        self._out[topic].publish(msg)
        if not something:
            self._out["interaction/replies"].publish(m.WizardReply(topic="mark"))
        printed: list[SessionEvent] = []
        end = time.monotonic() + 60
        while True:
            assert time.monotonic() < end, f"nothing was printed of {msg}"
            self._executor.spin_once(timeout_sec=0.02)
            try:
                printed.append(self._follower.events.get_nowait())
            except queue.Empty:
                continue
            fact = printed[-1].fact
            if isinstance(fact, RecordedReply) and fact.topic == "mark":
                return printed[:-1]
            if something:
                return printed

    def close(self) -> None:
        self._executor.shutdown()
        self._follower.destroy_node()
        self._peer.destroy_node()
        rclpy.try_shutdown(context=self._context)


@pytest.fixture
def followed(ros_domain: int) -> Iterator[Followed]:
    made = Followed(ros_domain)
    yield made
    made.close()


@pytest.mark.parametrize("words", [str, *REWORDINGS.values()], ids=["its own", *REWORDINGS])
def test_in_whatever_words_it_reports_the_same_facts(followed: Followed, words: Rewording):
    facts = []
    for topic, msg, something in COURSE:
        printed = followed.prints(topic, reworded(msg, words), something=something)
        assert len(printed) == something, (msg, printed)
        facts += [event.fact for event in printed]
    assert tuple(type(f) for f in facts) == FACTS
    expected = conversions.prompt_from_msg(COURSE[3][1])
    assert without_sentences(facts[2]) == without_sentences(expected)
    assert [f.accepted for f in facts if isinstance(f, RecordedReply)] == [False, True]
    assert [f.purpose for f in facts if isinstance(f, Progress)] == [Purpose.PICK, Purpose.RETURN, Purpose.NONE]
