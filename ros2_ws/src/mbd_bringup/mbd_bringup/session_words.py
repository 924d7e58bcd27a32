"""The command line of ``session``: every argument of the launch file, as an option or as ``name:=value``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError

from mbd_bringup.launch_arguments import ARGUMENTS, given_in, refuse_unknown

_ON_OFF = ("simulated", "execute", "scripted_wizard", "console", "markers", "resume")
_INSTEAD = {"--out": "--folder"}  # what the demo calls it
_DESCRIPTION = """One session: the nodes that the launch file starts, with the same arguments, and its events on this
terminal. Ctrl-C ends it. Led by a person (with --console, or --no-scripted-wizard) it stays until then, so that the
pages do; else it ends when the session is done."""


def session_parser() -> argparse.ArgumentParser:
    """Takes ARGUMENTS as options, and words ``name:=value``."""
    parser = CommandParser(prog="session", description=_DESCRIPTION, instead=_INSTEAD)
    parser.add_argument("words", nargs="*", metavar="name:=value", help="any of these, as the launch file takes it")
    for name, argument in ARGUMENTS.items():
        default = f" (default: {argument.default})" if argument.default else ""
        option, text = f"--{name.replace('_', '-')}", argument.description + default
        if name in _ON_OFF:
            parser.add_argument(option, dest=name, action=argparse.BooleanOptionalAction, default=None, help=text)
        else:
            parser.add_argument(option, dest=name, metavar=name.upper(), help=text)
    return parser


def given_words(words: Sequence[str] | None = None) -> dict[str, str]:
    """Argument name -> what a person gave for it on this command line.

    Args:
        words: of the command line; None: this process's.

    Raises:
        MbdError: a word that is no ``name:=value``, has another name than those of ARGUMENTS, or is given twice.
        SystemExit: an option there is not, or ``--help``.
    """
    parsed = session_parser().parse_intermixed_args(words)
    for word in parsed.words:
        if ":=" not in word:
            raise MbdError(f"'{word}' is no name:=value, as task:=sorting; options begin with --, as --task sorting")
    refuse_unknown(parsed.words)
    given = given_in(parsed.words)
    for name in ARGUMENTS:
        value = getattr(parsed, name)
        if value is None:
            continue
        if name in given:
            raise MbdError(f"{name} is given twice, as an option and as {name}:={given[name]}; give it once")
        given[name] = str(value).lower() if isinstance(value, bool) else value
    return given


def all_words(given: dict[str, str]) -> dict[str, str]:
    """Those given, and the defaults of all others."""
    return {name: argument.default for name, argument in ARGUMENTS.items()} | given


def words_of_next(given: dict[str, str]) -> dict[str, str]:
    """What of a command line holds for the plan's next session too: not what names this one."""
    of_this_one = ("session", "participant", "task", "seed", "resume", "deviation")
    return {name: word for name, word in given.items() if name not in of_this_one}
