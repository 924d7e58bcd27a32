"""The mapping node as a process of its own, over real messages."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Vector3
from mbd_bringup.domain import private_domain
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.synthetic import random_scene
from mbd_model.assists import Assist, Denial
from mbd_model.objects import Role, Scene
from mbd_model.ros.conversions import assists_to_msg, estimate_from_msg, scene_to_msg, task_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_model.task import StepKind, Task, TaskStep
from mbd_msgs import msg as m
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

pytestmark = pytest.mark.node

rng = np.random.default_rng(3)
SOURCE, TARGET = random_scene(rng, Role.SOURCE, 5, "s"), random_scene(rng, Role.TARGET, 5, "t")
TASK = Task(SOURCE, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(SOURCE.ids)), stamp=1.0)


class Bench:
    """A mapping node in a process, and this process's publishers and subscribers around it."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        self.process: subprocess.Popen[str] | None = None
        self.stamp = 10
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("bench", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.estimates: list[m.MappingEstimate] = []
        self.diagnostics: list[DiagnosticStatus] = []
        self.task = self.node.create_publisher(m.Task, "demonstration/task", LATCHED)
        self.target = self.node.create_publisher(m.Scene, "perception/target_scene", LATCHED)
        self.assists = self.node.create_publisher(m.Assists, "interaction/assists", LATCHED)
        self.node.create_subscription(m.MappingEstimate, "mapping/estimate", self.estimates.append, LATCHED)
        self.node.create_subscription(DiagnosticArray, "diagnostics", lambda a: self.diagnostics.extend(a.status), 10)
        self.parameters = self.node.create_client(SetParameters, "mapping/set_parameters")

    def start(self, *parameters: str) -> None:
        """Start the node."""
        flags = [word for p in parameters for word in ("-p", p)]
        command = [sys.executable, "-m", "mbd_mapping.ros.node", "--ros-args", *flags]
        self.process = subprocess.Popen(command, env=self.environment, stderr=subprocess.PIPE, text=True)

    def until(self, what: Callable[[], bool], timeout: float = 60.0) -> None:
        """Spin until something holds."""
        end = time.monotonic() + timeout
        while not what():
            assert time.monotonic() < end, "it did not happen in time"
            self.executor.spin_once(timeout_sec=0.1)

    def answer(self, assists: list[Assist], denials: tuple[Denial, ...] = ()) -> m.MappingEstimate:
        """Publish task, scene and assists, these with a stamp of their own, and wait for their estimate."""
        self.stamp += 1
        self.task.publish(task_to_msg(TASK))
        self.target.publish(scene_to_msg(TARGET))
        self.assists.publish(assists_to_msg(tuple(assists), float(self.stamp), "trial", denials))
        return self.estimate_of(self.stamp)

    def until_reported(self, level: bytes, *words: str) -> None:
        """Wait for a diagnostic of that level with these words in it."""
        self.until(lambda: any(d.level == level and all(word in d.message for word in words) for d in self.diagnostics))

    def estimate_of(self, stamp: int) -> m.MappingEstimate:
        """Wait for the estimate made from the assists of that time."""
        self.until(lambda: bool(self.estimates) and self.estimates[-1].assists_stamp.sec == stamp)
        return self.estimates[-1]

    def set_threshold(self, value: float) -> SetParameters.Response:
        """Change the parameter while the node runs."""
        assert self.parameters.wait_for_service(60.0)
        request = SetParameters.Request(parameters=[Parameter("threshold", value=value).to_parameter_msg()])
        future = self.parameters.call_async(request)
        self.until(future.done)
        return future.result()

    def stop(self, how: signal.Signals = signal.SIGINT) -> int:
        """End the node; returns its exit code."""
        assert self.process is not None
        self.process.send_signal(how)
        self.process.communicate(timeout=60.0)
        return self.process.returncode

    def close(self) -> None:
        """End everything."""
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.communicate()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    """A domain of its own, and no node in it yet."""
    made = Bench(ros_domain)
    yield made
    made.close()


@pytest.fixture(scope="module")
def running() -> Iterator[Bench]:
    """One node with threshold 0.5 for the tests that leave it as it was."""
    with private_domain() as domain:
        made = Bench(domain)
        made.start("threshold:=0.5")
        yield made
        made.close()


def test_the_estimate_is_that_of_the_function(running: Bench) -> None:
    """What the node publishes is what ``infer`` returns for the same inputs, with their stamps."""
    assists = [Assist("s0", "t3"), Assist("s1", "t0", 1)]
    msg = running.answer(assists)
    expected = infer(TASK, TARGET, assists, MappingConfig(threshold=0.5))
    assert estimate_from_msg(msg) == expected
    assert msg.threshold == 0.5
    assert msg.confident == (expected.confidence >= 0.5)
    assert (msg.session, msg.task_stamp.sec, msg.header.stamp.sec) == ("trial", 1, msg.assists_stamp.sec)


def test_evidence_takes_its_features_as_measured(bench: Bench) -> None:
    """What the node of "evidence" publishes is ``infer`` with the noise of a camera, question and gain included."""
    bench.start("strategy:=evidence")
    assists = [Assist("s0", "t3"), Assist("s1", "t0", 1)]
    config = MappingConfig(strategy="evidence")
    found, expected = estimate_from_msg(bench.answer(assists)), infer(TASK, TARGET, assists, config)
    assert (found.mapping.pairs, found.next_question) == (expected.mapping.pairs, expected.next_question)
    assert found.confidence == pytest.approx(expected.confidence)
    assert found.information_gain == pytest.approx(expected.information_gain)


def test_a_confirmed_assist_and_a_denial_reach_the_inference(bench: Bench) -> None:
    bench.start("strategy:=evidence")
    assists, denials = [Assist("s0", "t3", confirmed=True)], (Denial("s1", "t0"),)
    found = estimate_from_msg(bench.answer(assists, denials))
    expected = infer(TASK, TARGET, assists, MappingConfig(strategy="evidence"), denials)
    assert found.mapping.pairs == expected.mapping.pairs and found.mapping.as_dict["s0"] == "t3"
    assert found.confidence == pytest.approx(expected.confidence)
    unasked = infer(TASK, TARGET, [Assist("s0", "t3")], MappingConfig(strategy="evidence"))
    assert found.confidence != pytest.approx(unasked.confidence)


def test_an_undo_leaves_no_trace(running: Bench) -> None:
    """A shorter list gives the estimate there was before the longer one."""
    before = estimate_from_msg(running.answer([]))
    running.answer([Assist("s0", "t3")])
    assert estimate_from_msg(running.answer([])) == before


def test_the_threshold_may_change_while_running(running: Bench) -> None:
    """A new threshold is published with the same estimate; one out of range is refused and changes nothing."""
    before = estimate_from_msg(running.answer([]))
    assert running.set_threshold(0.9).results[0].successful
    running.until(lambda: running.estimates[-1].threshold == 0.9)
    assert estimate_from_msg(running.estimates[-1]) == replace(before, threshold=0.9)
    refused = running.set_threshold(1.5).results[0]
    assert not refused.successful
    assert "1.5" in refused.reason or "range" in refused.reason
    assert running.set_threshold(float("nan")).results[0].successful is False
    assert running.answer([]).threshold == 0.9
    assert running.set_threshold(0.5).results[0].successful
    running.until(lambda: running.estimates[-1].threshold == 0.5)


def test_assists_that_cannot_be_are_reported(running: Bench) -> None:
    """Unknown ids and contradictions stand on the estimate and on diagnostics, and go when they are withdrawn."""
    warnings = running.answer([Assist("ghost", "t0"), Assist("s0", "t1"), Assist("s0", "t2")]).warnings
    assert ["ghost" in w for w in warnings] == [True, False]
    assert "contradicts" in warnings[1]
    running.until_reported(DiagnosticStatus.WARN, "ghost", "contradicts an earlier assist: s0 -> t1")
    running.diagnostics.clear()
    assert not running.answer([Assist("s0", "t1")]).warnings
    running.until_reported(DiagnosticStatus.OK, "up to date")


def spoilt(**values: object) -> m.Scene:
    """The target scene with other values in its first object."""
    scene = scene_to_msg(TARGET)
    for name, value in values.items():
        setattr(scene.objects[0], name, value)
    return scene


BAD_SCENES = {
    "a source scene": (scene_to_msg(SOURCE), "role source"),
    "an id twice": (spoilt(id="t1"), "unique"),
    "no volume": (spoilt(volume=0.0), "volume 0.0"),
    "a hue that is no number": (spoilt(has_hue=True, hue=math.nan), "hue nan"),
    "a centroid that is no number": (spoilt(centroid=Point(x=math.nan)), "centroid"),
    "an endless size": (spoilt(size=Vector3(x=math.inf, y=0.1, z=0.1)), "size"),
    "an unknown relation": (spoilt(relations=[m.SpatialRelation(kind=9, other_id="t1")]), "9"),
}


@pytest.mark.parametrize("what", sorted(BAD_SCENES))
def test_a_scene_that_cannot_be_is_refused_and_the_last_one_stays(running: Bench, what: str) -> None:
    """Its reason stands on diagnostics, the estimate is still made from the last good scene, and the next one helps."""
    scene, reason = BAD_SCENES[what]
    before = estimate_from_msg(running.answer([Assist("s0", "t3")]))
    running.diagnostics.clear()
    running.target.publish(scene)
    running.until_reported(DiagnosticStatus.ERROR, reason)
    running.stamp += 1
    running.assists.publish(assists_to_msg((Assist("s0", "t3"),), float(running.stamp), "trial"))
    assert estimate_from_msg(running.estimate_of(running.stamp)) == before
    running.diagnostics.clear()
    running.answer([])
    running.until_reported(DiagnosticStatus.OK, "up to date")


def test_an_empty_scene_is_no_error(running: Bench) -> None:
    """With nothing on the table there is a mapping of nothing, without confidence; the node goes on."""
    running.answer([])
    running.target.publish(scene_to_msg(Scene(Role.TARGET, ())))
    running.until(lambda: len(running.estimates[-1].mapping.pairs) == 0)
    assert running.estimates[-1].confidence == 0.0
    running.answer([])
    running.until(lambda: len(running.estimates[-1].mapping.pairs) == 5)


def test_a_killed_node_states_the_same_again(bench: Bench) -> None:
    """Killed and started again, the node gets its inputs again and publishes the same estimate; Ctrl-C ends it well."""
    bench.start()
    before = bench.answer([Assist("s0", "t3")])
    bench.stop(signal.SIGKILL)
    bench.estimates.clear()
    bench.start()
    assert bench.estimate_of(bench.stamp) == before
    assert bench.stop() == 0


@pytest.mark.parametrize(
    ("parameter", "reason"),
    [("strategy:=psychic", "evidence"), ("sigma:=-1.0", "a positive number")],
)
def test_a_parameter_that_cannot_be_stops_the_node_with_a_reason(bench: Bench, parameter: str, reason: str) -> None:
    """The node ends with code 1 and names what it may be."""
    bench.start(parameter)
    assert bench.process is not None
    error = bench.process.communicate(timeout=60.0)[1]
    assert bench.process.returncode == 1
    assert parameter.split(":=")[1] in error
    assert reason in error
