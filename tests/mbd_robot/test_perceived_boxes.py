"""What stands around the arm: as perceived, then as the robot at work moves it; real messages in one process."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from cell_and_robot import Playground, playground
from mbd_execution.choosing import next_motion
from mbd_execution.execution import Work, begin, motion_ended
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_execution.ros.scene_publisher import ScenePublisher
from mbd_execution.synthetic import blocks, demonstration, obeys
from mbd_model.objects import Role, Scene
from mbd_model.ros.conversions import scene_to_msg, stamp_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_msgs import msg as m
from mbd_robot.geometry import Obstacle, Surroundings
from mbd_robot.ros.perceived_boxes import PerceivedBoxes

SIZES = {"1": (0.05, 0.05, 0.06), "2": (0.05, 0.07, 0.06), "3": (0.05, 0.05, 0.08)}
ZONE = Obstacle("the teacher's hands", (0.5, 0.0, 1.0), (0.1, 0.1, 2.0))


class Around:
    """The boxes that a robot node keeps clear of, and who tells it."""

    def __init__(self, there: Playground) -> None:
        self.there = there
        self.target = there.node.create_publisher(m.Scene, "perception/target_scene", LATCHED)
        self.execution = ScenePublisher(there.node, "base")

    def listen(self) -> PerceivedBoxes:
        return PerceivedBoxes(self.there.node, (ZONE,), heed=True)

    def perceived(self, stamp: int = 0) -> Scene:
        scene = blocks(Role.TARGET, "t", SIZES)
        msg = scene_to_msg(scene)
        msg.header.stamp = stamp_to_msg(stamp)
        self.target.publish(msg)
        return scene


@pytest.fixture
def around(ros_domain: int) -> Iterator[Around]:
    with playground(ros_domain) as there:
        yield Around(there)


def begun() -> Work:
    task = demonstration(blocks(Role.SOURCE, "s", SIZES), [("s1", "s2", (0.0, 0.0)), ("s3", "s2", (0.0, 0.0))])
    return begin(plan(task, blocks(Role.TARGET, "t", SIZES), {"s1": "t1", "s2": "t2", "s3": "t3"}), HandConfig())


def until(work: Work, carrying: bool) -> Work:
    while (work.carried is not None) is not carrying:
        work, motion = next_motion(work, allowed=True)
        assert motion is not None
        work = motion_ended(work, obeys(motion, work))
    return work


def names(now: Surroundings) -> tuple[list[str], list[str]]:
    return [o.name for o in now.obstacles], [o.name for o in now.held.boxes]


def test_what_the_robot_moves_is_kept_clear_of_where_it_is_and_what_it_holds_is_with_the_hand(around: Around):
    boxes = around.listen()
    scene = around.perceived()
    around.there.until(lambda: len(boxes.now().obstacles) == 4)
    assert names(boxes.now()) == ([ZONE.name, "t1", "t2", "t3"], [])
    carrying = until(begun(), carrying=True)
    around.execution.publish(carrying)
    around.there.until(lambda: boxes.now().held.boxes)
    assert names(boxes.now()) == ([ZONE.name, "t2", "t3"], ["t1"])
    held = boxes.now().held
    grasp = carrying.carried.held.grasp
    assert held.boxes[0].centre == pytest.approx(scene.objects[0].centroid)
    assert held.boxes[0].size == pytest.approx((0.05, 0.05, 0.06))
    assert held.grasp.position == pytest.approx((grasp.x, grasp.y, grasp.z))
    around.execution.publish(until(carrying, carrying=False))
    around.there.until(lambda: not boxes.now().held.boxes)
    now = {o.name: o for o in boxes.now().obstacles}
    assert set(now) == {ZONE.name, "t1", "t2", "t3"}
    assert now["t1"].centre[:2] == pytest.approx(now["t2"].centre[:2], abs=1e-3)
    assert now["t1"].centre[2] == pytest.approx(0.09, abs=5e-3)


def test_a_robot_node_that_comes_back_takes_the_later_of_what_was_latched_and_then_all_that_is_new(around: Around):
    boxes = around.listen()
    got: list[m.Scene] = []
    around.there.node.create_subscription(m.Scene, "perception/target_scene", got.append, LATCHED)
    around.execution.publish(until(begun(), carrying=True))
    around.there.until(lambda: boxes.now().held.boxes)
    around.perceived(stamp=1)  # said before, and delivered last
    around.there.until(lambda: got)
    for _ in range(20):
        around.there.executor.spin_once(timeout_sec=0.0)
    assert names(boxes.now())[1] == ["t1"]
    around.perceived(stamp=2)  # of a cell whose clock began again
    around.there.until(lambda: not boxes.now().held.boxes)
    assert names(boxes.now())[0] == [ZONE.name, "t1", "t2", "t3"]
