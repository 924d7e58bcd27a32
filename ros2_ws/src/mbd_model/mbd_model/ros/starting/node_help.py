"""``--help`` of a node: what it is and which parameters it has, in place of its start."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterable, Sequence
from functools import partial

from mbd_model.parameters import ParameterTable
from mbd_model.ros.starting.command_line import HOW, other_words

WIDTH = 100  # characters of a line


def help_of(name: str, description: str, tables: Iterable[ParameterTable]) -> str:
    """The page.

    Args:
        name: of the node's executable.
        description: of the node, its first sentence counts.
        tables: of its parameters.
    """
    lines = [f"usage: {name} [--ros-args -p PARAMETER:=VALUE ... --params-file FILE ...]", ""]
    lines += textwrap.wrap(" ".join(description.split("\n\n", maxsplit=1)[0].split()), WIDTH)
    lines += ["", *parameter_lines(tables)]
    return "\n".join([*lines, "", "exit code: 0 when it was asked to end, 1 when it could not start", ""])


def parameter_lines(tables: Iterable[ParameterTable]) -> list[str]:
    """How parameters are given, and which there are, each with its description below it."""
    lines = [f"{HOW[0].upper()}{HOW[1:]}", ""]
    for table in tables:
        for spec in table.specs:
            default = list(spec.default) if isinstance(spec.default, tuple) else spec.default
            unit = f" [{spec.unit}]" if spec.unit else ""
            kind = "required" if spec.required else f"default {default!r}"
            allowed = f", {spec.allowed}" if spec.allowed else ""
            lines.append(f"  {spec.name} ({spec.kind}{unit}{allowed}, {kind})")
            lines += textwrap.wrap(spec.description, WIDTH, initial_indent="      ", subsequent_indent="      ")
    return lines


def answer_help(name: str, made_by: object, words: Sequence[str] | None = None) -> None:
    """Print the page and exit with 0 when this process was asked for it.

    Args:
        name: of the node's executable.
        made_by: the node's class, or what makes it; its module knows its tables, of which those named so count when
            there are any.
        words: the command line; None: this process's.

    Raises:
        SystemExit: code 0, after the page.
    """
    if not {"-h", "--help"} & set(other_words(sys.argv[1:] if words is None else words)):
        return
    if isinstance(made_by, partial):
        made_by = made_by.func
    module = sys.modules[str(getattr(made_by, "__module__", "__main__"))]
    known = list({id(v): v for v in vars(module).values() if isinstance(v, ParameterTable)}.values())
    found = [table for table in known if table.node == name] or known
    description = (module.__doc__ or "").strip() or str(getattr(made_by, "__doc__", "") or "")
    sys.stdout.write(help_of(name, description, found))
    raise SystemExit(0)
