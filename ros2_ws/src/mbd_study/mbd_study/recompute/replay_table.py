"""A session's recorded estimates beside the ones computed again, as a table: ``replay BAG --check``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbd_bag.session.command_line import read_session
from mbd_model.estimate import Feature, MappingEstimate
from mbd_model.times import to_seconds
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_study.recompute.reevaluation import EstimateCheck
from mbd_study.recompute.session_check import check_session, difference_lines
from mbd_study.recompute.stages import RecomputeFrom
from mbd_study.tables.session_table import doubt_text

AGREES, DIFFERS = 0, 1


def replay_table(comparisons: Sequence[EstimateCheck], start: int) -> Table:
    """One row for each recorded estimate.

    Args:
        comparisons: in the order recorded.
        start: log time that counts as 0 [ns].
    """
    table = Table(header_style="bold", box=None, pad_edge=False)
    table.add_column(r"t \[s]", justify="right")
    table.add_column("assists", justify="right")
    table.add_column("recorded")
    table.add_column("recomputed")
    table.add_column("agrees")
    for entry in comparisons:
        table.add_row(
            f"{to_seconds(entry.recorded.log_time - start):.1f}",
            str(entry.recorded.value.num_assists),
            _summary(entry.recorded.value),
            "[red]inputs missing[/]" if entry.computed is None else _summary(entry.computed),
            "[green]yes[/]" if entry.agrees else "[red]no[/]: " + ", ".join(d.field for d in entry.differences),
        )
    return table


def _features(features: Sequence[Feature]) -> str:
    return "+".join(features) or "no feature"


def _summary(estimate: MappingEstimate) -> str:
    if not estimate.mapping.pairs:
        return "no mapping"
    text = f"{_features(estimate.winning)}, confidence {estimate.confidence:.6f}"
    if estimate.ties != 1:
        text += f", {estimate.ties} ties"
    doubt = doubt_text(estimate)
    return f"{text}, {doubt}" if doubt else text


def verdict(comparisons: Sequence[EstimateCheck]) -> str:
    """One sentence, as rich markup."""
    agreeing = sum(c.agrees for c in comparisons)
    if agreeing == len(comparisons):
        return f"[bold green]agrees: {agreeing} of {len(comparisons)} estimates[/]"
    return f"[bold red]differs: only {agreeing} of {len(comparisons)} estimates agree[/]"


def print_check(path: Path, console: Console) -> int:
    """Compute a bag's estimates again from its assists, print both side by side, and return the exit code.

    Raises:
        MbdError: the bag cannot be used.
    """
    bag, session = read_session(path, console)
    checked = check_session(bag, session, RecomputeFrom.ASSISTS)
    console.print(replay_table(checked.comparisons, bag.start))
    for line in difference_lines(checked, bag.start):
        console.print(f"  {escape(line)}", highlight=False, soft_wrap=True)
    console.print(verdict(checked.comparisons))
    return AGREES if checked.agrees else DIFFERS
