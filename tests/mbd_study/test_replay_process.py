"""A replayed bag is a session again for whoever listens: nodes run again on it publish what they published then."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from ament_index_python.packages import get_package_prefix
from mbd_bag.errors import BagError
from mbd_bag.replay.replay_plan import phase_start, published_topics
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.storage.bag import Bag
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs.msg import Assists, MappingEstimate, SessionState, Task
from mbd_study.synthetic import SyntheticSession
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_srvs.srv import SetBool, Trigger

pytestmark = pytest.mark.timeout(120)


def executable(package: str, name: str) -> str:
    return str(Path(get_package_prefix(package)) / "lib" / package / name)


class Listener:
    """Receives what is published in a domain, and starts processes in it."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("listener", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.processes: list[subprocess.Popen[str]] = []

    def record(self, kind: type, topic: str, qos: object = LATCHED) -> list[object]:
        received: list[object] = []
        self.node.create_subscription(kind, topic, received.append, qos)
        return received

    def start(self, *command: str) -> subprocess.Popen[str]:
        pipe = subprocess.PIPE
        process = subprocess.Popen(command, env=self.environment, stdout=pipe, stderr=subprocess.STDOUT, text=True)
        self.processes.append(process)
        return process

    def spin_until(self, happened: Callable[[], bool], what: str, timeout: float = 60.0) -> None:
        deadline = time.monotonic() + timeout
        while not happened():
            assert time.monotonic() < deadline, f"waited {timeout} s for {what}"
            self.executor.spin_once(timeout_sec=0.05)

    def spin_for(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def call(self, kind: type, name: str, request: object) -> object:
        client = self.node.create_client(kind, name)
        self.spin_until(client.service_is_ready, name)
        future = client.call_async(request)
        self.spin_until(future.done, name)
        return future.result()

    def close(self) -> None:
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.wait()
            process.stdout.close()
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def listener(ros_domain: int) -> Iterator[Listener]:
    made = Listener(ros_domain)
    yield made
    made.close()


def test_a_mapping_node_run_again_on_a_replay_publishes_what_it_published_under_its_own_parameters(
    listener: Listener, made: SyntheticSession, made_bag: Path
):
    recorded = [r.value for r, _ in made.recorded.estimates]
    received = listener.record(MappingEstimate, "mapping/estimate", EVENTS)
    replay = executable("mbd_study", "replay")
    mapping = listener.start(executable("mbd_mapping", "mapping"), "--ros-args", "-p", "threshold:=0.9")
    process = listener.start(replay, str(made_bag), "--rate", "40", "--without", "mapping")
    listener.spin_until(lambda: process.poll() is not None, "the end of the replay")
    output = process.communicate()[0]
    assert process.returncode == 0, output
    listener.spin_until(lambda: bool(received) and received[-1].num_assists == 3, "the last estimate")
    last = received[-1]
    assert [(p.source_id, p.target_id) for p in last.mapping.pairs] == list(recorded[-1].mapping.pairs)
    assert last.confidence == pytest.approx(recorded[-1].confidence, abs=1e-6)
    assert last.threshold == pytest.approx(0.9)
    assert mapping.poll() is None


def test_a_replay_can_be_paused_stepped_and_taken_to_another_phase(listener: Listener, made_bag: Path):
    states = listener.record(SessionState, "interaction/state")
    tasks = listener.record(Task, "demonstration/task")
    assists = listener.record(Assists, "interaction/assists")
    process = listener.start(executable("mbd_study", "replay"), str(made_bag), "--paused", "--phase", "observe_target")
    # Started late in the session, it first states what is latched by then.
    listener.spin_until(lambda: bool(tasks) and bool(states), "the facts before the phase")
    assert not assists
    listener.spin_for(0.5)
    assert process.poll() is None
    before = states[-1].phase
    assert listener.call(Trigger, "replay/step", Trigger.Request()).success
    listener.spin_until(lambda: states[-1].phase > before, "a step")
    assert listener.call(Trigger, "replay/next_phase", Trigger.Request()).message in ("assist", "done")
    assert listener.call(SetBool, "replay/pause", SetBool.Request(data=False)).message == "playing"
    listener.spin_until(lambda: bool(assists), "assists")
    process.terminate()


def test_pictures_come_as_they_were_published_and_only_what_runs_again_is_left_out(listener: Listener, made_bag: Path):
    pictures = listener.record(Image, "camera/color/image_raw", SENSOR)
    process = listener.start(executable("mbd_study", "replay"), str(made_bag), "--rate", "20", "--loop")
    listener.spin_until(lambda: len(pictures) >= 3, "pictures of two rounds")
    assert (pictures[0].width, pictures[0].height, pictures[0].encoding) == (640, 480, "rgb8")
    process.terminate()
    bag = Bag(made_bag)
    everything = {t.name for t in published_topics(bag)}
    kept = {t.name for t in published_topics(bag, ["mapping", "perception"])}
    assert everything - kept == {"/mapping/estimate", "/perception/source_scene", "/perception/target_scene"}
    with pytest.raises(BagError, match=r"no node 'arm'.*perception"):
        published_topics(bag, ["arm"])
    with pytest.raises(BagError, match="no phase 'execute'; it reached: observe_source, demonstrate"):
        phase_start(session_from_bag(bag), "execute")
