"""``replay BAG``: publish a session's topics live; ``--check``: compute its estimates again offline, and compare."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace

import rclpy
from mbd_bag.errors import BagError
from mbd_bag.replay.replay_keys import HELP, poll, pressed_keys
from mbd_bag.replay.replay_plan import OUTPUTS, phase_start, published_topics
from mbd_bag.ros.replay_node import TICK, ReplayNode, ReplayOptions
from mbd_bag.session.command_line import bag_parser, read_session, run_tool
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from rclpy.executors import ExternalShutdownException
from rich.console import Console

from mbd_study.recompute.replay_table import print_check

_PATIENCE = 60.0  # [s] to wait for the nodes that run anew


def _parser() -> ArgumentParser:
    parser = bag_parser(__doc__ or "")
    parser.add_argument("--check", action="store_true", help="compute every estimate again offline, and compare")
    parser.add_argument("--rate", type=float, default=1.0, help="recorded seconds a second (default 1)")
    parser.add_argument("--loop", action="store_true", help="start over at the end")
    parser.add_argument("--paused", action="store_true", help="begin paused")
    parser.add_argument("--phase", help="start where this phase began (demonstrate, assist, ...)")
    parser.add_argument(
        "--without", nargs="+", default=[], metavar="NODE", help=f"nodes that run anew: {', '.join(OUTPUTS)}"
    )
    parser.add_argument("--compressed", action="store_true", help="leave compressed pictures as they were recorded")
    return parser


def _tool() -> int:
    parser = _parser()
    # What follows --ros-args is for the node (remappings and the like).
    arguments, rest = parser.parse_known_args()
    if rest and rest[0] != "--ros-args":
        parser.error(f"unknown argument {rest[0]}")
    if arguments.check:
        return print_check(arguments.bag, Console())
    if arguments.rate <= 0:
        raise BagError(f"--rate {arguments.rate}: expected more than 0 recorded seconds a second")
    console = Console()
    bag, session = read_session(arguments.bag, console)
    return _play(bag, session, arguments, rest, console)


def _play(bag: Bag, session: RecordedSession, arguments: Namespace, ros_words: list[str], console: Console) -> int:
    options = ReplayOptions(
        topics=published_topics(bag, arguments.without, compressed=arguments.compressed),
        begin=phase_start(session, arguments.phase) if arguments.phase else bag.start,
        rate=arguments.rate,
        loop=arguments.loop,
        paused=arguments.paused,
        without=tuple(arguments.without),
    )
    rclpy.init(args=ros_words)
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
    return 0


def _obey(node: ReplayNode, key: str, console: Console) -> bool:
    """Do what a key says; False when it is to end."""
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
        where = (playback.position - node.begin) / 1e9
        state = f"{'paused' if playback.paused else 'playing'}, {playback.rate:g} x{', loop' if playback.loop else ''}"
        console.print(f"t {where:.1f} s, {state}", highlight=False)
    return key != "q"


def main() -> None:
    """Entry point: exit code 0 at the end (or all estimates agree), 1 when some differ, 2 when the bag is of no use."""
    run_tool("replay", _tool)
