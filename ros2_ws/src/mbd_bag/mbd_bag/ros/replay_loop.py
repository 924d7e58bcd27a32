"""The replay from start to end: publish what is due, obey keys, stop at the end or when asked to."""

from __future__ import annotations

import time
from collections.abc import Sequence

import rclpy
from mbd_model.times import to_seconds
from rclpy.executors import ExternalShutdownException
from rich.console import Console

from mbd_bag.errors import BagError
from mbd_bag.replay.replay_keys import HELP, poll, pressed_keys
from mbd_bag.replay.replay_options import ReplayOptions
from mbd_bag.ros.replay_node import TICK, ReplayNode
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag

_PATIENCE = 60.0  # [s] to wait for the nodes that run again


def play(bag: Bag, session: RecordedSession, options: ReplayOptions, ros_args: Sequence[str], console: Console) -> None:
    """Replay a session; returns at its end, or when a key or a signal ends it.

    Args:
        bag: to read.
        session: what it holds.
        options: what to publish and how.
        ros_args: ROS arguments (remappings and the like), ``--ros-args`` first; empty for none.
        console: prints what happens.

    Raises:
        BagError: the nodes that run again did not come up.
    """
    rclpy.init(args=list(ros_args))
    try:
        node = ReplayNode(bag, session, options)
        deadline = time.monotonic() + _PATIENCE
        while why := node.ready():
            if time.monotonic() > deadline:
                raise BagError(f"{why} after {_PATIENCE:.0f} s; start the nodes of --without, or leave them out of it")
            rclpy.spin_once(node, timeout_sec=0.05)
        node.publish_facts()
        console.print(f"publishing {len(options.topics)} topics of session {session.name}", highlight=False)
        with pressed_keys() as terminal:
            if terminal:
                console.print(HELP, style="dim")
            while not node.playback.finished and _obey(node, poll() if terminal else "", console):
                rclpy.spin_once(node, timeout_sec=TICK)
                node.tick()
        # What was published last is still on its way to whoever listens.
        until = time.monotonic() + 1.0
        while time.monotonic() < until:
            rclpy.spin_once(node, timeout_sec=0.05)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
    console.print("the end")


def _obey(node: ReplayNode, key: str, console: Console) -> bool:
    """Do what a key means; False when it is to end."""
    playback = node.playback
    if key == " ":
        playback.paused = not playback.paused
    elif key == "s":
        node.step()
    elif key in "+-" and key:
        playback.rate = playback.rate * 2.0 if key == "+" else playback.rate / 2.0
    elif key == "n":
        node.next_phase()
    elif key == "l":
        playback.loop = not playback.loop
    if key and key in " s+-nl":
        where = to_seconds(playback.position - node.begin)
        state = f"{'paused' if playback.paused else 'playing'}, {playback.rate:g} x{', loop' if playback.loop else ''}"
        console.print(f"t {where:.1f} s, {state}", highlight=False)
    return key != "q"
