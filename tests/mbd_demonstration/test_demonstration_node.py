"""The demonstration node turns what it receives between start and stop into the latched task."""

from __future__ import annotations

from pathlib import Path

from demonstration_session import Session, steps_of
from mbd_demonstration.gripper import GripperAction
from mbd_demonstration.synthetic import Demonstration
from mbd_model.ros.conversions import time_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_model.times import to_nanoseconds
from mbd_msgs.msg import Task, WizardGripper
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock


def test_spoken_commands_give_the_demonstrated_steps(session: Session, shown: Demonstration):
    session.observe(shown)
    assert session.ask("start").success
    session.play(shown)
    answer = session.ask("stop")
    assert answer.success, answer.message
    session.until(lambda: len(session.tasks) > 0)
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]


def test_a_demonstration_in_which_the_gripper_never_closed_fails_reporting_it(session: Session, shown: Demonstration):
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    answer = session.ask("stop")
    assert not answer.success and "the gripper never closed" in answer.message
    assert session.tasks == []


def test_start_without_a_source_scene_states_what_to_do(session: Session):
    answer = session.ask("start")
    assert not answer.success and "observe the source objects first" in answer.message


def test_stop_without_start_reports_it(session: Session):
    answer = session.ask("stop")
    assert not answer.success and "no demonstration is being recorded" in answer.message


def test_who_asks_to_stop_again_has_the_same_answer_and_the_task_once_more(session: Session, shown: Demonstration):
    """The dialogue may be killed with the answer on its way; it comes back and asks again."""
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    first, again = session.ask("stop"), session.ask("stop")
    assert first.success and again.success and again.message == first.message
    session.until(lambda: len(session.tasks) == 2)
    assert serialize_message(session.tasks[0]) == serialize_message(session.tasks[1])
    session.ask("discard")
    assert not session.ask("stop").success


def test_a_command_without_stamp_is_meant_now(session: Session, shown: Demonstration):
    """No pose is near the wall clock's now, so the event is stated with its distance in time."""
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    session.words.publish(WizardGripper(command=int(GripperAction.CLOSE)))
    session.until(lambda: len(session.node.recording.events) == 1)
    answer = session.ask("stop")
    assert not answer.success and "nearest tool pose is" in answer.message


def test_what_was_recorded_so_far_is_published_while_it_runs(session: Session, shown: Demonstration):
    recorded: list[Task] = []
    session.peer.create_subscription(Task, "demonstration/recorded", recorded.append, LATCHED)
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    session.until(lambda: bool(recorded) and len(recorded[-1].steps) == len(shown.steps))


def test_start_without_a_tool_pose_is_refused_at_once_with_the_reason(session: Session, shown: Demonstration):
    session.observe(shown)
    answer = session.call("start")
    assert not answer.success
    assert "no tool pose comes on" in answer.message and "none came since this node started" in answer.message


def test_while_a_simulated_clock_stands_start_waits_for_no_tool_pose(
    ros_domain: int, tmp_path: Path, shown: Demonstration
):
    """A node that came back just then would refuse what the clock waits for, and the session would never go on."""
    session = Session(ros_domain, tmp_path, use_sim_time=True)
    clock = session.peer.create_publisher(Clock, "clock", 10)
    session.observe(shown)

    def simulated(seconds: float) -> None:
        def there() -> bool:
            clock.publish(Clock(clock=time_to_msg(seconds)))
            return session.node.get_clock().now().nanoseconds == to_nanoseconds(seconds)

        session.until(there)

    simulated(50.0)
    assert session.call("start").success
    simulated(51.0)
    assert session.call("start").success
    simulated(53.5)
    answer = session.call("start")
    assert not answer.success and "no tool pose comes on" in answer.message
    session.close()
