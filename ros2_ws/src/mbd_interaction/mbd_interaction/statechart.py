"""The dialogue's statechart and table, drawn from its code.

``python -m mbd_interaction.statechart docs/wizard.md`` puts both into the page, between their marks.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

from mbd_model.errors import MbdError
from mbd_model.session import Phase

from mbd_interaction.events import INTERNAL, WIZARD, Signal
from mbd_interaction.transitions import RUNNING, TABLE

BEGIN, END = "<!-- dialogue: begin (python -m mbd_interaction.statechart) -->", "<!-- dialogue: end -->"
WIDTH = 120  # characters of a line of documentation
# These leave every phase in which they are taken where it is: drawn, they would hide the rest.
STAYING = frozenset({Signal.PAUSE, Signal.RESUME, Signal.GRIPPER, Signal.NOTE})


def arrows() -> dict[tuple[Phase, Phase], list[Signal]]:
    """The signals that may lead from one phase to another one."""
    found: defaultdict[tuple[Phase, Phase], list[Signal]] = defaultdict(list)
    for (phase, signal), rule in TABLE.items():
        for after in rule.leads_to:
            if after is not phase:
                found[phase, after].append(signal)
    return dict(sorted(found.items()))


def mermaid() -> str:
    """The statechart: phases, and what leads from one to another; abort is one arrow from all that run, one back."""
    lines = ["stateDiagram-v2", "    [*] --> OBSERVE_SOURCE", "    state running {"]
    for (before, after), signals in arrows().items():
        if Phase.ABORTED not in (before, after) and Phase.DONE not in (before, after):
            lines += _arrow(f"        {before.name} --> {after.name}: ", signals)
    lines.append("    }")
    for (before, after), signals in arrows().items():
        if after is not Phase.ABORTED and Phase.DONE in (before, after):
            lines += _arrow(f"    {before.name} --> {after.name}: ", signals)
    aborting = {before for before, after in arrows() if after is Phase.ABORTED}
    if aborting == set(RUNNING):
        lines.append(f"    running --> {Phase.ABORTED.name}: {Signal.ABORT}")
    else:
        lines += [f"    {before.name} --> {Phase.ABORTED.name}: {Signal.ABORT}" for before in sorted(aborting)]
    lines.append(f"    {Phase.ABORTED.name} --> running: {Signal.RESUME} (to the phase it was in)")
    lines += ["    DONE --> [*]", "    ABORTED --> [*]"]
    return "\n".join(lines)


def _arrow(start: str, signals: Sequence[Signal]) -> list[str]:
    """One arrow for all signals, or more where they fill more than a line."""
    lines: list[str] = []
    for signal in signals:
        if lines and len(lines[-1]) + len(signal) + 2 <= WIDTH:
            lines[-1] += f", {signal}"
        else:
            lines.append(start + signal)
    return lines


def table() -> str:
    """Markdown: which wizard event each phase takes, and where it leads; an empty cell is refused with a reason."""
    signals = [s for s in WIZARD if s is not Signal.UNREADABLE and s not in INTERNAL]
    lines = ["| event | " + " | ".join(p.name for p in Phase) + " |", "|---" * (len(Phase) + 1) + "|"]
    for signal in signals:
        cells = []
        for phase in Phase:
            rule = TABLE.get((phase, signal))
            others = [p.name for p in rule.leads_to if p is not phase] if rule else []
            if rule and set(RUNNING) <= set(rule.leads_to):
                others = ["where it was"]
            stays = ["stays"] if rule and phase in rule.leads_to else []
            cells.append(" or ".join(stays + ([f"→ {' or '.join(others)}"] if others else [])))
        lines.append(f"| {signal} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def section() -> str:
    """What stands between the marks of the page."""
    return f"{BEGIN}\n```mermaid\n{mermaid()}\n```\n\n{table()}\n{END}"


def updated(page: str) -> str:
    """The page with the present statechart and table; raises MbdError when it lacks the marks."""
    if BEGIN not in page or END not in page:
        raise MbdError(f"the page lacks the marks '{BEGIN}' and '{END}': put both where the statechart belongs")
    return page[: page.index(BEGIN)] + section() + page[page.index(END) + len(END) :]


def main() -> None:
    """Write the section into the page named on the command line, or print it."""
    if len(sys.argv) < 2:
        sys.stdout.write(section() + "\n")
        return
    page = Path(sys.argv[1])
    page.write_text(updated(page.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
