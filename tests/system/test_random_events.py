"""Three thousand random wizard events, sent to a real dialogue under a real recorder."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import rclpy
from mbd_bag.storage.bag import Bag
from mbd_bringup.nodes import NodeSpec
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.background import spin_in_background
from mbd_bringup.ros.live_session import install_prefixes
from mbd_model.ros.conversions import state_from_msg
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_msgs import msg as m

EVENT_COUNT, BATCH = 3_000, 100


def random_event(rng: np.random.Generator) -> tuple[str, object]:
    """A wizard topic's name and a message for it, sensible or not."""
    word = str(rng.choice(["s1", "t1", "t9", "", "tea pot", "<b>"]))
    code = int(rng.integers(0, 12))
    return [
        ("gripper", m.WizardGripper(command=code)),
        ("handed", m.WizardHanded(object_id=word)),
        ("pointed", m.WizardPointed(object_id=word)),
        ("demonstration", m.WizardDemonstration(command=code)),
        ("command", m.WizardCommand(command=code)),
        ("overwrite", m.WizardOverwrite(step_index=code, object_id=word)),
        ("note", m.WizardNote(text=word)),
        ("revision", m.WizardRevision(change=code, step=code, object=word)),
    ][int(rng.integers(8))]


@pytest.mark.timeout(600)
def test_every_one_is_answered_once_and_state_and_bag_stay_readable(ros_domain: int, tmp_path: Path):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("random_wizard", context=context)
    replies: Counter[bool] = Counter()
    node.create_subscription(m.WizardReply, "interaction/replies", lambda r: replies.update([r.accepted]), EVENTS)
    states: list[m.SessionState] = []
    node.create_subscription(m.SessionState, "interaction/state", states.append, LATCHED)
    kinds = {name: type(random_event_of(name)) for name in TOPICS}
    out = {name: node.create_publisher(kind, f"wizard/{name}", EVENTS) for name, kind in kinds.items()}
    end = spin_in_background(node)
    bag = tmp_path / "bag"
    rng = np.random.default_rng(1)
    with SessionProcesses(
        install_prefixes(["mbd_bag", "mbd_interaction"]), tmp_path / "logs", {"ROS_DOMAIN_ID": str(ros_domain)}
    ) as processes:
        processes.start(NodeSpec("mbd_bag", "recorder", {"bag": str(bag)}))
        processes.start(NodeSpec("mbd_interaction", "interaction"))
        wait(lambda: bool(states) and all(p.get_subscription_count() == 2 for p in out.values()), "the nodes")
        for sent in range(BATCH, EVENT_COUNT + 1, BATCH):
            for _ in range(BATCH):
                name, msg = random_event(rng)
                out[name].publish(msg)
            # No faster than they are answered: the claim is about the dialogue, not about a queue without end.
            wait(lambda sent=sent: replies.total() >= sent, f"{sent} replies")
        assert processes.dead() == []
        assert processes.stop(patience=60) == []
    end()
    assert replies.total() == EVENT_COUNT
    assert replies[True] > 0 and replies[False] > 0
    state_from_msg(states[-1])
    recorded = Counter(message.topic for message in Bag(bag).messages())
    assert recorded["/interaction/replies"] == EVENT_COUNT
    assert sum(n for topic, n in recorded.items() if topic.startswith("/wizard/")) == EVENT_COUNT


TOPICS = ("gripper", "handed", "pointed", "demonstration", "command", "overwrite", "note", "revision")


def random_event_of(name: str) -> object:
    """An empty message of a wizard topic."""
    return getattr(m, "Wizard" + name.capitalize())()


def wait(done: object, what: str, seconds: float = 120.0) -> None:
    """Until it is so; fails when it does not come to be."""
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end, f"{what} did not come within {seconds:g} s"
        time.sleep(0.01)
