"""What the command-line tools share: a bag as the argument, and clear words for one that cannot be used."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Callable
from pathlib import Path

from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError
from rich.console import Console
from rich.markup import escape

from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag

BAD_BAG = 2


def bag_parser(description: str) -> ArgumentParser:
    """A parser whose one positional argument is the bag."""
    parser = CommandParser(description=description)
    parser.add_argument("bag", type=Path, help="folder that a recorder wrote, or one of its files")
    return parser


def open_session(path: Path) -> tuple[Bag, RecordedSession]:
    """A bag and its session; raises BagError."""
    # Here, not above: messages are needed to read a bag only, and the rest works where there is no ROS.
    from mbd_bag.ros.session_conversions import session_from_bag

    bag = Bag(path)
    return bag, session_from_bag(bag)


def read_session(path: Path, console: Console) -> tuple[Bag, RecordedSession]:
    """A bag and its session, with a word on what is missing from it; raises BagError."""
    bag, session = open_session(path)
    for problem in session.problems:
        note(problem, console)
    return bag, session


def note(problem: str, console: Console) -> None:
    """Print on the console what is missing from a bag."""
    console.print(f"[yellow]note:[/] {escape(problem)}", highlight=False, soft_wrap=True)


def run_tool(name: str, tool: Callable[[], int]) -> None:
    """Run a tool and end the process with its exit code; a bag or place that cannot be used states why and ends with 2.

    Args:
        name: of the tool.
        tool: returns the exit code.
    """
    try:
        code = tool()
    except MbdError as error:
        Console(stderr=True).print(f"[red]{name}:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        code = BAD_BAG
    except OSError as error:
        # A place that cannot be written to is a mistake of a person's, no fault of the tool.
        words = f"{error.filename or 'a file'} cannot be used: {error.strerror or error}; choose another place"
        Console(stderr=True).print(f"[red]{name}:[/] {escape(words)}", highlight=False, soft_wrap=True)
        code = BAD_BAG
    except KeyboardInterrupt:
        code = 130
    sys.exit(code)
