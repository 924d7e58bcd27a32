"""``replay BAG``: publish a session's topics live; ``--check``: compute its estimates again offline, and compare."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from mbd_bag.errors import BagError
from mbd_bag.replay.replay_options import ReplayOptions
from mbd_bag.replay.replay_plan import OUTPUTS, phase_start, published_topics
from mbd_bag.session.command_line import bag_parser, read_session, run_tool
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from mbd_model.command_line.values import above_zero
from rich.console import Console

from mbd_study.recompute.replay_table import print_check


def _parser() -> ArgumentParser:
    parser = bag_parser(__doc__ or "")
    parser.add_argument("--check", action="store_true", help="compute every estimate again offline, and compare")
    parser.add_argument("--rate", type=above_zero, default=1.0, help="recorded seconds a second (default 1)")
    parser.add_argument("--loop", action="store_true", help="start over at the end")
    parser.add_argument("--paused", action="store_true", help="begin paused")
    parser.add_argument("--phase", help="start where this phase began (demonstrate, assist, ...)")
    parser.add_argument(
        "--without", nargs="+", default=[], metavar="NODE", help=f"nodes that run again: {', '.join(OUTPUTS)}"
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
    from mbd_bag.ros.replay_loop import play

    options = ReplayOptions(
        topics=published_topics(bag, arguments.without, compressed=arguments.compressed),
        begin=phase_start(session, arguments.phase) if arguments.phase else bag.start,
        rate=arguments.rate,
        loop=arguments.loop,
        paused=arguments.paused,
        without=tuple(arguments.without),
    )
    play(bag, session, options, ros_words, console)
    return 0


def main() -> None:
    """Entry point: exit code 0 at the end (or all estimates agree), 1 when some differ, 2 when the bag is of no use."""
    run_tool("replay", _tool)
