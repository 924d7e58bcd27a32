"""The execution node looks by perception's service: real messages and actions, one process, perception of the test."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from mbd_execution.synthetic import blocks
from mbd_model.objects import Role, Scene
from mbd_model.ros.conversions import scene_to_msg, stamp_to_msg
from mbd_msgs import msg as m
from mbd_msgs.srv import Observe

from tests.mbd_execution.test_stopped_arm import SIZES, StoppableArm

pytestmark = pytest.mark.node


class Watched:
    """An arm before the node, and what its camera sees.

    Attributes:
        hidden: ids of objects that are not seen; None: nothing is, perception fails.
        requests: what was asked of perception.
    """

    def __init__(self, domain: int, state_dir: Path) -> None:
        self.hidden: frozenset[str] | None = frozenset()
        self.requests: list[Observe.Request] = []
        self.arm = StoppableArm(domain, state_dir)
        self.arm.peer.create_service(Observe, "perception/observe", self._observe)
        self.arm.start(look_again=True)

    def _observe(self, request: Observe.Request, response: Observe.Response) -> Observe.Response:
        self.requests.append(request)
        if self.hidden is None:
            response.message = "no table in view"
            return response
        seen = tuple(o for o in blocks(Role.TARGET, "t", SIZES).objects if o.object_id not in self.hidden)
        response.scene, response.success = scene_to_msg(Scene(Role.TARGET, seen)), True
        return response

    def answer(self, verdict: int) -> None:
        """The dialogue's answer: the same assists under a new stamp, their estimate, and the verdict."""
        assists, estimate = m.Assists(), m.MappingEstimate(confidence=1.0, strategy="mbd")
        assists.header.stamp = stamp_to_msg(4)
        estimate.mapping.pairs = [m.Correspondence(source_id=f"s{k}", target_id=f"t{k}") for k in (1, 2, 3)]
        estimate.task_stamp, estimate.scene_stamp, estimate.assists_stamp = (stamp_to_msg(k) for k in (1, 2, 4))
        self.arm.out["interaction/assists"].publish(assists)
        self.arm.out["mapping/estimate"].publish(estimate)
        state = m.SessionState(session="s", phase=m.SessionState.EXECUTE, verdict=verdict)
        self.arm.out["interaction/state"].publish(state)


@pytest.fixture
def watched(ros_domain: int, tmp_path: Path) -> Iterator[Watched]:
    made = Watched(ros_domain, tmp_path)
    yield made
    made.arm.close()


def test_it_looks_before_the_first_motion_asks_about_what_is_gone_and_goes_on_when_that_is_back(watched: Watched):
    watched.hidden, arm = frozenset({"t1"}), watched.arm
    arm.until(lambda: bool(arm.progress) and arm.progress[-1].status == m.Progress.FAILED, "for the question")
    now = arm.progress[-1]
    assert (now.failure, now.step_index) == (m.Progress.FAILURE_NOT_THERE, 0) and "t1" in now.text
    assert arm.goals == []
    assert all(r.answer_only and r.role == Observe.Request.TARGET for r in watched.requests)
    watched.hidden = frozenset()
    watched.answer(m.SessionState.VERDICT_YES)
    arm.until(lambda: "close" in arm.goals, "for the grasp")


def test_a_table_that_is_not_seen_is_looked_at_again_and_then_asked_about(watched: Watched):
    watched.hidden, arm = None, watched.arm
    arm.until(lambda: bool(arm.progress) and arm.progress[-1].status == m.Progress.FAILED, "for the question")
    assert arm.progress[-1].failure == m.Progress.FAILURE_NOT_SEEN
    assert "no table in view" in arm.progress[-1].text and len(watched.requests) == 2
    assert "close" not in arm.goals
