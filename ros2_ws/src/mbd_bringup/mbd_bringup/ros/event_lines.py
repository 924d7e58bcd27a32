"""What happens in a session as lines on a terminal: when, who, what."""

from __future__ import annotations

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_bringup.ros.follow import SessionEvent

STYLES = {
    "phase": "bold cyan",
    "robot": "green",
    "mapping": "yellow",
    "wizard": "dim",
    "teacher": "magenta",
    "arm": "blue",
}


def print_event(event: SessionEvent, elapsed: float, console: Console) -> None:
    """Print when, who and what; what is long goes on below itself."""
    style = STYLES.get(event.speaker, "white")
    if event.phase is not None:
        console.rule(f"[{style}]{event.text}[/]", align="left")
        return
    line = Table.grid(padding=(0, 2, 0, 0))
    line.add_column(width=8, justify="right")
    line.add_column(width=13, style=style)
    line.add_column()
    line.add_row(f"{elapsed:.1f} s", event.speaker, escape(event.text))
    console.print(line, highlight=False)
