"""``replay BAG``: compute every estimate of a session again, offline, and say whether the bag agrees."""

from __future__ import annotations

from collections.abc import Sequence

from mbd_model.estimate import Feature, MappingEstimate
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_study.command_line import bag_parser, read_session, run_tool
from mbd_study.reevaluation import Comparison, reevaluate

AGREES, DIFFERS = 0, 1


def replay_table(comparisons: Sequence[Comparison], start: int) -> Table:
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
            f"{(entry.recorded.log_time - start) / 1e9:.1f}",
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
    return text if estimate.ties == 1 else f"{text}, {estimate.ties} ties"


def verdict(comparisons: Sequence[Comparison]) -> str:
    """One sentence, as rich markup."""
    agreeing = sum(c.agrees for c in comparisons)
    if agreeing == len(comparisons):
        return f"[bold green]agrees: {agreeing} of {len(comparisons)} estimates[/]"
    return f"[bold red]differs: only {agreeing} of {len(comparisons)} estimates agree[/]"


def _tool() -> int:
    arguments = bag_parser(__doc__ or "").parse_args()
    console = Console()
    bag, session = read_session(arguments.bag, console)
    comparisons = reevaluate(session)
    console.print(replay_table(comparisons, bag.start))
    for entry in comparisons:
        for difference in entry.differences:
            console.print(
                f"  t {(entry.recorded.log_time - bag.start) / 1e9:.1f} s, {difference.field}: recorded "
                f"{escape(difference.recorded)}, recomputed {escape(difference.computed)}",
                highlight=False,
                soft_wrap=True,
            )
    console.print(verdict(comparisons))
    return AGREES if all(c.agrees for c in comparisons) else DIFFERS


def main() -> None:
    """Entry point: exit code 0 when all estimates agree, 1 when some differ, 2 when the bag cannot be used."""
    run_tool("replay", _tool)
