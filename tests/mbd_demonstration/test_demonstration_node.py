"""The demonstration node turns what it receives between start and stop into the latched task."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from mbd_demonstration.finger_joint import read_gripper
from mbd_demonstration.gripper import GripperAction
from mbd_demonstration.journal import found
from mbd_demonstration.recording import Recording, understood
from mbd_demonstration.ros.node import DemonstrationNode
from mbd_demonstration.samples import Samples
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_model.objects import Role
from mbd_model.objects import Scene as SourceScene
from mbd_model.ros.conversions import scene_to_msg, time_from_msg, time_to_msg
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs.msg import Scene, Task, WizardGripper
from mbd_msgs.srv import ReviseTask
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

BEGIN = 100.0


class Session:
    """A demonstration node and, in the same process, those who talk to it."""

    def __init__(self, domain: int, state_dir: Path, **parameters: object) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        overrides = [Parameter(k, value=v) for k, v in {"state_dir": str(state_dir), **parameters}.items()]
        self._reads_joint = parameters.get("gripper_source") == "joint"
        self.node = DemonstrationNode(context=self.context, parameter_overrides=overrides)
        self.peer = rclpy.create_node("peer", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)
        self.scenes = self.peer.create_publisher(Scene, "perception/source_scene", LATCHED)
        self.poses = self.peer.create_publisher(PoseStamped, "j2n6s300_driver/out/tool_pose", SENSOR)
        self.joints = self.peer.create_publisher(JointState, "j2n6s300_driver/out/joint_state", SENSOR)
        self.words = self.peer.create_publisher(WizardGripper, "wizard/gripper", EVENTS)
        self.names = [f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)]
        self.tasks: list[Task] = []
        self.peer.create_subscription(Task, "demonstration/task", self.tasks.append, LATCHED)
        self.until(lambda: all(p.get_subscription_count() for p in (self.scenes, self.poses, self.joints, self.words)))

    def until(self, done: Callable[[], bool], seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if done():
                return
            self.executor.spin_once(timeout_sec=0.02)
        pytest.fail("waited in vain")

    def tool_is_there(self) -> None:
        """The driver publishes a tool pose, as it does all the time: nothing can be recorded without."""
        before = self.node._last_pose
        while self.node._last_pose == before:
            pose = PoseStamped()
            pose.header.frame_id = "j2n6s300_link_base"
            pose.header.stamp, pose.pose.orientation.w = time_to_msg(BEGIN - 50.0), 1.0
            self.poses.publish(pose)
            self.executor.spin_once(timeout_sec=0.05)

    def ask(self, request: str) -> Trigger.Response:
        if request == "start":
            self.tool_is_there()
        client = self.peer.create_client(Trigger, f"demonstration/{request}")
        self.until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.until(future.done)
        return future.result()

    def observe(self, shown: Demonstration) -> None:
        self.scenes.publish(scene_to_msg(shown.scene))
        self.until(lambda: self.node._scene is not None)

    def play(self, shown: Demonstration, *, words: bool = True) -> None:
        """Publish the recording as the robot and the wizard would."""
        names = self.names
        for t, p, q, g in zip(shown.stamps, shown.positions, shown.quaternions, shown.joint, strict=True):
            pose = PoseStamped()
            pose.header.stamp, pose.header.frame_id = time_to_msg(float(t)), shown.scene.frame_id
            pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = map(float, p)
            o = pose.pose.orientation
            o.x, o.y, o.z, o.w = map(float, q)
            joints = JointState(header=pose.header, name=names, position=[float(g)] * len(names))
            self._reaches(self.poses, pose, lambda: self.node._recording.poses)
            if self._reads_joint:
                self._reaches(self.joints, joints, lambda: self.node._recording.fingers.get(names[-1]))
        for event in shown.events if words else ():
            word = WizardGripper(command=int(event.action))
            word.header.stamp = time_to_msg(event.stamp)
            self.words.publish(word)
        if words and not self._reads_joint:
            self.until(lambda: len(self.node._recording.events) == len(shown.events))

    def _reaches(
        self, publisher: Publisher, msg: PoseStamped | JointState, arrived: Callable[[], Samples | None]
    ) -> None:
        """Publish until the node has it: sensor data may be lost, and the node leaves a repeated stamp out."""
        stamp = time_from_msg(msg.header.stamp)
        for _ in range(60):
            publisher.publish(msg)
            end = time.monotonic() + 1.0
            while time.monotonic() < end:
                samples = arrived()
                if samples is not None and stamp in samples.table()[-3:, 0]:
                    return
                self.executor.spin_once(timeout_sec=0.02)
        pytest.fail(f"{publisher.topic_name} did not reach the node")

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.peer.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def session(ros_domain: int, tmp_path: Path) -> Iterator[Session]:
    made = Session(ros_domain, tmp_path)
    yield made
    made.close()


@pytest.fixture(scope="module")
def shown() -> Demonstration:
    scene = random_scene(np.random.default_rng(3), 3)
    moves = (Move("s1", onto="s2"), Move("s3", onto="s1"))
    return demonstrate(scene, moves, Sensing(rate=10.0), np.random.default_rng(3), begin=BEGIN)


def steps_of(task: Task) -> list[tuple[int, str]]:
    return [(s.kind, s.primary_object) for s in task.steps]


def test_spoken_commands_give_the_demonstrated_steps(session: Session, shown: Demonstration):
    session.observe(shown)
    assert session.ask("start").success
    session.play(shown)
    answer = session.ask("stop")
    assert answer.success, answer.message
    session.until(lambda: len(session.tasks) > 0)
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]


def test_the_finger_joint_gives_the_demonstrated_steps(ros_domain: int, tmp_path: Path, shown: Demonstration):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    assert session.ask("stop").success
    session.until(lambda: len(session.tasks) > 0)
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    session.close()


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


def test_a_command_without_stamp_is_meant_now(session: Session, shown: Demonstration):
    """No pose is near the wall clock's now, so the event is stated with its distance in time."""
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    session.words.publish(WizardGripper(command=int(GripperAction.CLOSE)))
    session.until(lambda: len(session.node._recording.events) == 1)
    answer = session.ask("stop")
    assert not answer.success and "nearest tool pose is" in answer.message


def test_a_node_that_comes_back_publishes_its_task_again(ros_domain: int, tmp_path: Path, shown: Demonstration):
    first = Session(ros_domain, tmp_path)
    first.observe(shown)
    first.ask("start")
    first.play(shown)
    first.ask("stop")
    first.close()
    again = Session(ros_domain, tmp_path)
    again.until(lambda: len(again.tasks) > 0)
    assert steps_of(again.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    again.close()


def test_the_last_step_can_be_dropped(session: Session, shown: Demonstration):
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    session.ask("stop")
    answer = session.ask("delete_last")
    assert answer.success and answer.message == "deleted step 4, PLACE s1; 3 steps left", answer.message
    session.until(lambda: len(session.tasks) > 1)
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps[:-1]]


def test_the_last_step_can_be_shown_again(session: Session, shown: Demonstration):
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    session.ask("stop")
    assert session.ask("rerecord_last").success
    now = SourceScene(Role.SOURCE, shown.after)
    again = demonstrate(now, (Move("s3", onto="s2"),), Sensing(rate=10.0), np.random.default_rng(4), begin=200.0)
    session.play(dataclasses.replace(again, scene=shown.scene))
    assert session.ask("stop").success
    session.until(lambda: len(session.tasks) > 2)
    assert steps_of(session.tasks[-1])[:-1] == [(int(k), i) for k, i in shown.steps[:-1]]


def test_a_node_reads_off_the_joint_what_the_files_tool_reads(ros_domain: int, tmp_path: Path):
    """Live and from files: the same samples, as noisy as they come, give the same steps and the same problems."""
    rng = np.random.default_rng(8)
    scene = random_scene(rng, 4)
    recorder = Sensing(rate=15.0, dropout=0.1, shuffle=0.2, joint_std=0.02, half_closings=1, ramp=0.8)
    shown = demonstrate(scene, (Move("s1", onto="s2"), Move("s3", onto="s4")), recorder, rng, begin=BEGIN)
    begins_closed = shown.stamps > shown.events[0].stamp + 1.0
    received = dataclasses.replace(
        shown, **{k: getattr(shown, k)[begins_closed] for k in ("stamps", "positions", "quaternions", "joint")}
    )
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.observe(shown)
    session.ask("start")
    session.play(received, words=False)
    answer = session.ask("stop")
    session.until(lambda: len(session.tasks) > 0)
    session.close()
    path = ToolTrajectory.from_samples(received.stamps, received.positions, received.quaternions)
    offline = understood(path, read_gripper(received.stamps, received.joint), scene, stamp=0.0)
    assert steps_of(session.tasks[-1]) == [(int(s.kind), s.primary_object) for s in offline.steps]
    assert list(session.tasks[-1].problems) == list(offline.problems)
    assert "began with the gripper closed" in answer.message
    ends = [time_from_msg(s.end) for s in session.tasks[-1].steps]
    assert ends == pytest.approx([s.end for s in offline.steps], abs=1e-6)


def test_steps_read_off_the_joint_are_shown_while_it_runs(ros_domain: int, tmp_path: Path, shown: Demonstration):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    recorded: list[Task] = []
    session.peer.create_subscription(Task, "demonstration/recorded", recorded.append, LATCHED)
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    session.until(lambda: bool(recorded) and len(recorded[-1].steps) == len(shown.steps))
    session.ask("start")
    session.until(lambda: len(recorded[-1].steps) == 0)
    session.close()


def test_what_was_recorded_so_far_is_published_while_it_runs(session: Session, shown: Demonstration):
    recorded: list[Task] = []
    session.peer.create_subscription(Task, "demonstration/recorded", recorded.append, LATCHED)
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    session.until(lambda: bool(recorded) and len(recorded[-1].steps) == len(shown.steps))


def test_start_without_a_tool_pose_is_refused_at_once_with_the_reason(session: Session, shown: Demonstration):
    session.observe(shown)
    client = session.peer.create_client(Trigger, "demonstration/start")
    session.until(client.service_is_ready)
    future = client.call_async(Trigger.Request())
    session.until(future.done)
    answer = future.result()
    assert not answer.success
    assert "no tool pose comes on" in answer.message and "none came since this node started" in answer.message


def test_joint_states_with_names_and_no_positions_are_left_out_and_counted(
    ros_domain: int, tmp_path: Path, shown: Demonstration
):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.observe(shown)
    session.ask("start")
    empty = JointState(name=[f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)])
    while session.node._recording.empty == 0:
        session.joints.publish(empty)
        session.executor.spin_once(timeout_sec=0.02)
    session.play(shown, words=False)
    session.ask("stop")
    session.until(lambda: len(session.tasks) > 0)
    session.close()
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    assert any("names and no positions" in problem for problem in session.tasks[-1].problems)


def test_a_recording_whose_node_died_goes_on_where_it_was(ros_domain: int, tmp_path: Path, shown: Demonstration):
    """Nothing is asked of the first node as it ends, as with kill -9: what counts is what was on disk before."""
    half = shown.events[1].stamp + 1.5
    parts = [
        dataclasses.replace(
            shown,
            **{k: getattr(shown, k)[chosen] for k in ("stamps", "positions", "quaternions", "joint")},
            events=tuple(e for e in shown.events if (e.stamp <= half) == first),
        )
        for first, chosen in ((True, shown.stamps <= half), (False, shown.stamps > half))
    ]
    one = Session(ros_domain, tmp_path)
    one.observe(shown)
    one.ask("start")
    one.play(parts[0])
    last = time.monotonic()
    file = tmp_path / "demonstration.recording"
    rows = len(one.node._recording.poses)

    def on_disk() -> bool:
        cut = found(file)
        recording = cut.into(Recording(shown.scene, 0.0)) if cut else None
        return recording is not None and len(recording.poses) == rows and len(recording.events) == 2

    one.until(on_disk)
    assert time.monotonic() - last < 2.0  # written each half second; the rest is this machine's
    one.close()
    other = Session(ros_domain, tmp_path)
    other.until(lambda: other.node._recording is not None and len(other.node._recording.poses) == rows)
    for event in parts[1].events:
        other.node._recording.add_event(event)
    other.play(dataclasses.replace(parts[1], events=()), words=False)
    assert other.ask("stop").success
    other.until(lambda: len(other.tasks) > 0)
    assert steps_of(other.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    assert not file.exists()
    other.close()


def test_fingers_of_another_hand_are_found_by_their_names(ros_domain: int, tmp_path: Path, shown: Demonstration):
    session = Session(ros_domain, tmp_path, gripper_source="joint")
    session.names = ["arm_joint_1", "robotiq_85_left_knuckle_joint"]
    session.observe(shown)
    session.ask("start")
    session.play(shown, words=False)
    session.ask("stop")
    session.until(lambda: len(session.tasks) > 0)
    session.close()
    assert steps_of(session.tasks[-1]) == [(int(k), i) for k, i in shown.steps]


@pytest.mark.parametrize(
    ("change", "left"),
    [
        ({"change": ReviseTask.Request.DELETE, "step": 0}, ["3"]),
        ({"change": ReviseTask.Request.MOVE, "step": 2, "to": 0}, ["3", "1"]),
        ({"change": ReviseTask.Request.CHANGE_OBJECT, "step": 1, "object": "s3"}, ["1", "3"]),
    ],
)
def test_a_step_is_corrected_by_service_and_the_task_keeps_it(session: Session, shown: Demonstration, change, left):
    session.observe(shown)
    session.ask("start")
    session.play(shown)
    session.ask("stop")
    client = session.peer.create_client(ReviseTask, "demonstration/revise")
    session.until(client.service_is_ready)
    future = client.call_async(ReviseTask.Request(**change))
    session.until(future.done)
    answer = future.result()
    assert answer.success, answer.message
    session.until(lambda: len(session.tasks) > 1)
    assert [s.primary_object[1:] for s in session.tasks[-1].steps if s.kind == 1] == left
    assert "by the teacher" in session.tasks[-1].problems[-1]
