"""Every node's parameters as docs/topics.md shows them, from the tables that the nodes declare."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from mbd_bag.recorder.parameters import RECORDER
from mbd_bag.replay.parameters import REPLAY
from mbd_bag.spool.parameters import SECOND_SPOOL, SPOOL
from mbd_cell.parameters import CELL, WIZARD
from mbd_console.parameters import CONSOLE
from mbd_demonstration.parameters import DEMONSTRATION
from mbd_execution.parameters import EXECUTION
from mbd_interaction.parameters import INTERACTION
from mbd_mapping.parameters import MAPPING
from mbd_model.errors import MbdError
from mbd_model.parameters import ParameterSpec, ParameterTable
from mbd_perception.parameters import PERCEPTION
from mbd_robot.parameters import CAMERA, ROBOT

from mbd_bringup.parameters import MARKERS

TABLES = (
    PERCEPTION,
    DEMONSTRATION,
    INTERACTION,
    EXECUTION,
    CONSOLE,
    MAPPING,
    RECORDER,
    SPOOL,
    SECOND_SPOOL,
    REPLAY,
    ROBOT,
    CAMERA,
    CELL,
    WIZARD,
    MARKERS,
)
BEGIN, END = "<!-- parameters: begin (tools/parameters_table --write) -->", "<!-- parameters: end -->"
WIDTH = 120  # characters of a line of documentation


def parameter_page(tables: Iterable[ParameterTable] = TABLES) -> str:
    """Markdown: a heading a node, a line or two a parameter."""
    parts = []
    for table in tables:
        entries = [_entry(spec) for spec in table.specs]
        parts.append("\n".join([f"### {table.node}", "", *entries]))
    return "\n\n".join(parts)


def _entry(spec: ParameterSpec) -> str:
    unit = f" [{spec.unit}]" if spec.unit else ""
    facts = [
        f"{spec.kind}{unit}",
        spec.allowed,
        "required" if spec.required else f"default `{_shown(spec)}`",
        "" if spec.read_only else "may change while running",
    ]
    text = f"- **`{spec.name}`** ({', '.join(f for f in facts if f)}): {spec.description}"
    lines = textwrap.wrap(text, WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines)


def _shown(spec: ParameterSpec) -> str:
    """The default as it is written on the command line."""
    if isinstance(spec.default, bool):
        return str(spec.default).lower()
    return str(list(spec.default)) if isinstance(spec.default, tuple) else str(spec.default) or "''"


def with_parameters(page: str) -> str:
    """A page with the parameters of today between its marks; raises MbdError when it lacks them."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise MbdError(f"the page of parameters lacks its marks {BEGIN} and {END}; put them back")
    return f"{before}{BEGIN}\n\n{parameter_page()}\n\n{END}{after}"
