"""The parser of every command of this project: what was wrong, in one line, with the word that was meant."""

from __future__ import annotations

import sys
from argparse import Action, ArgumentError, ArgumentParser, HelpFormatter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from mbd_model.command_line.values import finite, named_place, whole_number
from mbd_model.parameters import nearest

MISUSED = 2  # exit code of a command line that cannot be used
_UNKNOWN, _ABOUT = "unrecognized arguments: ", "argument "  # with which argparse begins what it says


class CommandParser(ArgumentParser):
    """argparse's parser, but for what it says of mistakes: its usage of thirty options pushes the reason out of sight.

    ``type=int`` takes no negative number, ``type=float`` neither nan nor infinity, ``type=Path`` no empty word.

    Args:
        prog: name of the command; None: that of the process.
        description: what it does; a module's docstring as it is.
        epilog: what stands below the options in the help.
        formatter_class: of the help.
        instead: an option that people take from another command -> the one that it has here.
        other: of ArgumentParser.
    """

    def __init__(
        self,
        prog: str | None = None,
        description: str | None = None,
        epilog: str | None = None,
        formatter_class: type[HelpFormatter] = HelpFormatter,
        instead: Mapping[str, str] | None = None,
        **other: Any,
    ) -> None:
        text = description and description.replace("``", "`")
        super().__init__(prog=prog, description=text, epilog=epilog, formatter_class=formatter_class, **other)
        self._instead = dict(instead or {})
        self._given: list[str] = []
        for kind, reading in ((int, whole_number), (float, finite), (Path, named_place)):
            self.register("type", kind, reading)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """As ArgumentParser's; remembers what was given, for an error's sake."""
        self._given = list(sys.argv[1:] if args is None else args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """End with exit code MISUSED and one line; of an option there is not, it names the one that was meant."""
        unknown = next((word for word in _options_among(self._given) if not self._knows(word)), "")
        if unknown:
            # Said first, whatever else is wrong: a required option that is misspelt is not there either.
            near = self._instead.get(unknown) or nearest(
                unknown, sorted(o for o in self.all_options() if o.startswith("--"))
            )
            message = f"there is no option {unknown}" + (f"; did you mean {near}?" if near else "")
        elif message.startswith(_UNKNOWN):
            # An empty word is one, too.
            message = f"'{message.removeprefix(_UNKNOWN).partition(' ')[0]}' is one word too many"
        self.exit(MISUSED, f"{self.prog}: {message.removeprefix(_ABOUT)}; --help says what it takes\n")

    def all_options(self) -> set[str]:
        """The options it takes, and those of its sub-commands."""
        options = set(self._option_string_actions)
        for action in self._actions:
            if isinstance(action.choices, Mapping):
                inner = [parser for parser in action.choices.values() if isinstance(parser, CommandParser)]
                options = options.union(*(parser.all_options() for parser in inner))
        return options

    def _knows(self, option: str) -> bool:
        # argparse takes the beginning of an option's name for it.
        return any(known.startswith(option) for known in self.all_options())

    def _get_value(self, action: Action, arg_string: str) -> Any:
        try:
            return super()._get_value(action, arg_string)
        except ArgumentError:
            if action.choices is None:
                raise
            raise _none_of(action, arg_string) from None  # an enum's member by another name

    def _check_value(self, action: Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            raise _none_of(action, str(value))


def _options_among(words: Sequence[str]) -> Iterable[str]:
    """The names of the options among words, but for what stands behind ``--``."""
    for word in words:
        if word == "--":
            return
        if word.startswith("-") and word.lstrip("-")[:1].isalpha():
            yield word.partition("=")[0]


def _none_of(action: Action, word: str) -> ArgumentError:
    choices = [str(choice) for choice in action.choices or ()]
    near = nearest(word, choices)
    return ArgumentError(
        action, f"'{word}' is none of {', '.join(choices)}" + (f"; did you mean {near}?" if near else "")
    )
