"""The interaction node: wizard topics in; state, prompts, assists and replies out; other nodes are never waited for."""

from __future__ import annotations

import pytest
from mbd_model.ros.conversions import stamp_from_msg
from mbd_model.session import Phase
from mbd_msgs.msg import (
    Assist,
    MappingEstimate,
    Prompt,
    SessionState,
    WizardAnswer,
    WizardCommand,
    WizardDemonstration,
)
from mbd_msgs.srv import Observe
from rclpy.duration import Duration
from std_msgs.msg import Header
from std_srvs.srv import Trigger


def test_a_session_runs_to_executing(session):
    session.to_first_question()
    assert session.asked == ["observe source", "start", "stop", "observe target"]
    assert session.send("handed", object_id="t1").accepted
    session.until(lambda: len(session.received["assists"][-1].assists) == 1)
    session.infer(0.08)
    session.until(lambda: session.phase is Phase.EXECUTE)
    session.until(lambda: session.received["prompt"][-1].text.startswith("I am confident (0.08)."))
    assert session.send("command", command=WizardCommand.NEXT_PHASE).accepted
    session.until(lambda: session.phase is Phase.DONE)


def test_without_perception_the_reply_states_which_node_is_not_running(make_session):
    session = make_session(others=False)
    reply = session.send("command", command=WizardCommand.NEXT_PHASE)
    assert not reply.accepted and "the perception node is not running" in reply.reason
    assert session.phase is Phase.OBSERVE_SOURCE


def test_every_reply_names_its_topic_and_an_unknown_command_is_refused(session):
    reply = session.send("command", command=77)
    assert (reply.topic, reply.accepted) == ("wizard/command", False)
    assert "command 77 is unknown" in reply.reason


def test_a_sender_whose_clock_is_ahead_makes_no_later_answer_of_others_late(session):
    session.to_first_question()
    now = session.peer.get_clock().now()
    ahead = Header(stamp=(now + Duration(seconds=3600)).to_msg())
    assert session.send("command", command=WizardCommand.SKIP, header=ahead).accepted
    session.until(lambda: session.received["prompt"][-1].kind == Prompt.WHERE_DO_I_GO)
    right = Header(stamp=session.peer.get_clock().now().to_msg())
    assert session.send("pointed", object_id="t1", header=right).accepted


def test_a_broken_fact_is_ignored(session):
    session.to_first_question()
    session.estimates.publish(MappingEstimate(winning=["colour"]))
    assert session.send("handed", object_id="t1").accepted


def test_a_node_that_comes_back_asks_the_same_question(make_session):
    first = make_session()
    first.to_first_question()
    first.send("handed", object_id="t1")
    first.until(lambda: len(first.received["assists"][-1].assists) == 1)
    first.catch_up()
    stamp = first.received["assists"][-1].header.stamp
    again = make_session()
    again.until(lambda: again.phase is Phase.ASSIST and bool(again.received["assists"]))
    assert again.received["assists"][-1].header.stamp == stamp
    again._request("stop")(Trigger.Request(), Trigger.Response())
    again._observe(Observe.Request(role=Observe.Request.TARGET), Observe.Response())
    again.infer(0.0)
    again.until(lambda: any(p.kind == Prompt.WHERE_DO_I_GO for p in again.received["prompt"][-1:]))
    assert [a.target_id for a in again.received["state"][-1].assists] == ["t1"]


def test_a_node_that_comes_back_before_a_simulation_states_the_time_states_none_before_its_end(make_session):
    first = make_session()
    first.to_first_question()
    published = first.received["state"][-1].header.stamp
    again = make_session(use_sim_time=True)
    again.until(lambda: again.phase is Phase.ASSIST)
    assert stamp_from_msg(again.received["state"][-1].header.stamp) >= stamp_from_msg(published) > 0


@pytest.mark.parametrize(
    ("answer", "assists", "denials"), [(WizardAnswer.YES, [("t3", True)], []), (WizardAnswer.NO, [], ["t3"])]
)
def test_a_doubted_assist_is_asked_about_confirmed_by_a_yes_and_withdrawn_by_a_no(
    session, answer: int, assists: list, denials: list
):
    session.to_first_question()
    assert session.send("handed", object_id="t3").accepted
    session.catch_up()
    session.infer(0.5, doubted=Assist(source_id="s1", target_id="t3", kind=Assist.HANDED), doubt=0.8)
    session.until(lambda: session.received["state"][-1].awaiting == SessionState.AWAITING_CONFIRMATION)
    session.until(lambda: session.received["prompt"][-1].kind == Prompt.CONFIRM_ASSIST)
    assert list(session.received["prompt"][-1].target_ids) == ["t3"]
    refused = session.send("answer", answer=7)
    assert not refused.accepted and "expected YES (1) or NO (2)" in refused.reason
    assert session.send("answer", answer=answer).accepted
    session.until(lambda: [(a.target_id, a.confirmed) for a in session.received["assists"][-1].assists] == assists)
    assert [d.target_id for d in session.received["assists"][-1].denials] == denials


def test_a_node_that_comes_back_knows_what_was_denied(make_session):
    first = make_session()
    first.to_first_question()
    first.send("handed", object_id="t3")
    first.catch_up()
    first.infer(0.5, doubted=Assist(source_id="s1", target_id="t3", kind=Assist.HANDED), doubt=0.8)
    first.until(lambda: first.received["state"][-1].awaiting == SessionState.AWAITING_CONFIRMATION)
    assert first.send("answer", answer=WizardAnswer.NO).accepted
    first.until(lambda: [d.target_id for d in first.received["assists"][-1].denials] == ["t3"])
    again = make_session()
    again.until(lambda: bool(again.received["assists"]))
    assert [d.target_id for d in again.received["assists"][-1].denials] == ["t3"]
    assert [d.target_id for d in again.received["state"][-1].denials] == ["t3"]


def test_a_node_that_comes_back_amid_a_recording_publishes_that_it_records_and_awaits_the_stop(make_session):
    first = make_session()
    assert first.send("command", command=WizardCommand.NEXT_PHASE).accepted
    assert first.send("demonstration", command=WizardDemonstration.START).accepted
    first.until(lambda: first.received["state"][-1].recording)
    again = make_session()
    state = again.received["state"][-1]
    assert state.recording and state.awaiting == SessionState.AWAITING_DEMONSTRATION_STOP
    assert not again.send("demonstration", command=WizardDemonstration.START).accepted
    assert again.send("demonstration", command=WizardDemonstration.STOP).accepted
    again.until(lambda: again.phase is Phase.TUCK_AND_CLEAR and not again.received["state"][-1].recording)


def test_a_node_that_comes_back_awaits_the_word_for_the_request_it_was_killed_in(make_session):
    first = make_session(others=False, service_patience=60.0)
    first.out["command"].publish(WizardCommand(command=WizardCommand.NEXT_PHASE))
    first.until(lambda: first.received["state"][-1].awaiting == SessionState.AWAITING_OBSERVATION)
    again = make_session()
    again.until(lambda: again.received["state"][-1].awaiting == SessionState.AWAITING_NEXT_PHASE)
    assert again.send("command", command=WizardCommand.NEXT_PHASE).accepted


def test_another_session_starts_afresh(make_session):
    first = make_session()
    first.to_first_question()
    other = make_session(session="other")
    assert other.phase is Phase.OBSERVE_SOURCE
