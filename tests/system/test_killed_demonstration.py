"""kill -9 of the demonstration node amid the demonstration, in front of the real dialogue: processes, not stand-ins."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from mbd_bringup.nodes import NodeSpec
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.live_session import install_prefixes
from mbd_demonstration.journal import found
from mbd_demonstration.recording import Recording
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_scene
from mbd_model.ros.conversions import scene_to_msg, time_to_msg
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.session import Awaited, Phase
from mbd_msgs import msg as m
from mbd_msgs.srv import Observe
from rclpy.executors import SingleThreadedExecutor

SCENE = random_scene(np.random.default_rng(3), 3)
MOVES = (Move("s1", onto="s2"), Move("s3", onto="s1"))
POSE = "j2n6s300_driver/out/tool_pose"


class Laboratory:
    """The dialogue and the demonstration node as processes; here: the arm, the camera's node, the wizard."""

    def __init__(self, domain: int, folder: Path, processes: SessionProcesses) -> None:
        self.processes, self.file = processes, folder / "state" / "demonstration.recording"
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("laboratory", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.states: list[m.SessionState] = []
        self.replies: list[m.WizardReply] = []
        self.tasks: list[m.Task] = []
        self.recorded: list[m.Task] = []
        for kind, topic, kept, qos in (
            (m.SessionState, "interaction/state", self.states, LATCHED),
            (m.WizardReply, "interaction/replies", self.replies, EVENTS),
            (m.Task, "demonstration/task", self.tasks, LATCHED),
            (m.Task, "demonstration/recorded", self.recorded, LATCHED),
        ):
            self.node.create_subscription(kind, topic, kept.append, qos)
        self.scenes = self.node.create_publisher(m.Scene, "perception/source_scene", LATCHED)
        self.poses = self.node.create_publisher(PoseStamped, POSE, 100)
        self.out = {
            name: self.node.create_publisher(kind, f"wizard/{name}", EVENTS)
            for name, kind in (
                ("command", m.WizardCommand),
                ("demonstration", m.WizardDemonstration),
                ("gripper", m.WizardGripper),
            )
        }
        self.node.create_service(Observe, "perception/observe", self._observe)
        self.rest = PoseStamped()
        self.rest.header.frame_id, self.rest.pose.orientation.w = "elsewhere", 1.0
        self.node.create_timer(0.1, lambda: self.poses.publish(self.rest))  # the driver publishes all the time
        self.until(lambda: bool(self.states) and all(p.get_subscription_count() for p in self.out.values()))

    def _observe(self, _request: Observe.Request, response: Observe.Response) -> Observe.Response:
        self.scenes.publish(scene_to_msg(SCENE))
        response.success, response.message, response.scene = True, "3 objects", scene_to_msg(SCENE)
        return response

    def until(self, done: Callable[[], bool], what: str = "", seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not done():
            assert time.monotonic() < end, f"waited in vain {what}; replies {[r.reason for r in self.replies[-3:]]}"
            self.executor.spin_once(timeout_sec=0.02)

    def send(self, name: str, command: int, stamp: float = 0.0) -> m.WizardReply:
        before = len(self.replies)
        word = self.out[name].msg_type(command=command)
        word.header.stamp = time_to_msg(stamp)
        self.out[name].publish(word)
        self.until(lambda: len(self.replies) > before, f"for the reply to {name} {command}")
        return self.replies[-1]

    def start(self) -> None:
        """Begin to record; where the node just came back it may not have met the arm yet, and says so."""
        self.until(lambda: self.send("demonstration", m.WizardDemonstration.START).accepted, "for a beginning")

    def play(self, shown: Demonstration, begin: float, end: float) -> None:
        """What the arm does, and the wizard says, between two times [s]; all of it has come when this returns."""
        chosen = np.flatnonzero((shown.stamps >= begin) & (shown.stamps < end))
        for event in shown.events:
            if begin <= event.stamp < end:
                self.say(event.stamp, int(event.action))

        def came() -> bool:
            for k in chosen:
                pose = PoseStamped()
                pose.header.stamp, pose.header.frame_id = time_to_msg(float(shown.stamps[k])), SCENE.frame_id
                pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = map(float, shown.positions[k])
                o = pose.pose.orientation
                o.x, o.y, o.z, o.w = map(float, shown.quaternions[k])
                self.poses.publish(pose)
                self.executor.spin_once(timeout_sec=0.001)
            return self.on_disk(float(shown.stamps[chosen[-1]]))

        self.until(came, "for the poses to be on disk")

    def say(self, stamp: float, command: int) -> None:
        assert self.send("gripper", command, stamp).accepted

    def on_disk(self, stamp: float) -> bool:
        """Whether the pose of that time [s] is in the file of the recording within a second."""
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            cut = found(self.file)
            if cut is not None:
                stamps = cut.into(Recording(SCENE, 0.0)).poses.table()[:, 0]
                if stamps.size and np.abs(stamps - stamp).min() < 1e-3:
                    return True
            self.executor.spin_once(timeout_sec=0.05)
        return False

    def kill(self, meanwhile: Callable[[], None] = lambda: None) -> None:
        """Kill -9; the node comes back after what is done meanwhile, and goes on."""
        node = self.processes["demonstration"]
        node.process.kill()
        node.process.wait()
        meanwhile()
        before = len(self.recorded)
        self.processes.start(node.spec)
        self.until(lambda: len(self.recorded) > before, "for the recording to go on")

    @property
    def phase(self) -> Phase:
        return Phase(self.states[-1].phase)

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def laboratory(ros_domain: int, tmp_path: Path) -> Iterator[Laboratory]:
    prefixes = install_prefixes(["mbd_demonstration", "mbd_interaction"])
    with SessionProcesses(prefixes, tmp_path / "logs", {"ROS_DOMAIN_ID": str(ros_domain)}) as processes:
        state = {"state_dir": str(tmp_path / "state")}
        processes.start(NodeSpec("mbd_demonstration", "demonstration", state))
        processes.start(NodeSpec("mbd_interaction", "interaction", state))
        made = Laboratory(ros_domain, tmp_path, processes)
        yield made
        made.close()


def demonstration() -> Demonstration:
    """It begins now: the words of before a recording are none of it."""
    return demonstrate(SCENE, MOVES, Sensing(rate=10.0), np.random.default_rng(3), begin=time.time() + 1.0)


def steps_of(task: m.Task) -> list[tuple[int, str]]:
    return [(s.kind, s.primary_object) for s in task.steps]


def test_what_was_recorded_outlives_kill_9_and_what_nobody_saw_is_asked_for_again(laboratory: Laboratory):
    lab = laboratory
    assert lab.send("command", m.WizardCommand.NEXT_PHASE).accepted
    lab.start()
    shown = demonstration()
    expected = [(int(k), i) for k, i in shown.steps]
    begin, end = float(shown.stamps[0]), float(shown.stamps[-1]) + 1.0

    # Between two words nothing is lost.
    between = (shown.events[1].stamp + shown.events[2].stamp) / 2
    lab.play(shown, begin, between)
    lab.kill()
    lab.play(shown, between, end)
    answer = lab.send("demonstration", m.WizardDemonstration.STOP)
    assert answer.accepted, answer.reason
    lab.until(lambda: bool(lab.tasks))
    assert steps_of(lab.tasks[-1]) == expected
    assert any("was cut off" in p and "did nothing meanwhile" in p for p in lab.tasks[-1].problems)

    # A word that falls into the gap is not lost, but where the hand was then is: it is shown again, and all goes on.
    assert lab.send("command", m.WizardCommand.BACK).accepted
    lab.start()
    shown = demonstration()
    begin, end = float(shown.stamps[0]), float(shown.stamps[-1]) + 1.0
    word = shown.events[1]
    lab.play(shown, begin, word.stamp - 0.4)
    lab.kill(meanwhile=lambda: lab.say(word.stamp, int(word.action)))
    lab.play(shown, word.stamp + 0.6, end)
    answer = lab.send("demonstration", m.WizardDemonstration.STOP)
    assert not answer.accepted and "was cut off" in answer.reason and "show the task again" in answer.reason
    lab.until(lambda: lab.states[-1].awaiting == Awaited.DEMONSTRATION_START)
    assert not lab.file.exists()
    lab.start()
    shown = demonstration()
    lab.play(shown, float(shown.stamps[0]), float(shown.stamps[-1]) + 1.0)
    tasks = len(lab.tasks)
    assert lab.send("demonstration", m.WizardDemonstration.STOP).accepted
    lab.until(lambda: len(lab.tasks) > tasks)
    assert steps_of(lab.tasks[-1]) == expected
    assert lab.phase is Phase.TUCK_AND_CLEAR
