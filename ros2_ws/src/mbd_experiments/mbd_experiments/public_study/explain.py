"""`ros2 run mbd_experiments explain`: one inference step by step, similarity by similarity.

Without arguments it explains the example of docs/mapping.md; with --folder and --session one of the study's sessions.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import FEATURES, STRATEGIES, compare, infer, read_assists
from mbd_mapping.mbd import Competition, competing_sets
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import UNMAPPED, Pair, first_assists
from mbd_model.assists import Assist
from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError
from mbd_model.objects import Scene
from mbd_model.task import Task
from rich.console import Console
from rich.table import Table

from mbd_experiments.public_study.examples import EXAMPLES
from mbd_experiments.public_study.study_folder import read_study


def explain(task: Task, target: Scene, assists: Sequence[Assist], config: MappingConfig, console: Console) -> None:
    """Print E, the best mapping of each competing feature, and the estimate."""
    source = task.source
    comparison = compare(source, target, config)
    pairs = first_assists(read_assists(assists, source.ids, target.ids).pairs)
    layers, exists = comparison.at(pairs)
    for feature, layer, there in zip(FEATURES, layers, exists, strict=True):
        if there:
            table = Table("", *target.ids, title=f"similarity by {feature}")
            for name, row in zip(source.ids, layer, strict=True):
                table.add_row(name, *(f"{value:.4f}" for value in row))
            console.print(table)
    console.print(_race(task, target, comparison, pairs))
    estimate = infer(task, target, assists, config)
    shown = " ".join(f"{s}→{t}" for s, t in estimate.mapping.pairs)
    console.print(f"{config.strategy} after {len(assists)} assists: {shown}")
    console.print(f"  winning {' + '.join(estimate.winning)}, runner-up {' + '.join(estimate.runner_up) or 'none'}")
    console.print(f"  confidence {estimate.confidence:.4f}, goes on alone from {config.stop_at:.4f}")
    if estimate.next_question:
        console.print(f"  would ask about {estimate.next_question} ({estimate.information_gain:.2f} bit)")
    for warning in estimate.warnings:
        console.print(f"  warning: {warning}")


def _race(task: Task, target: Scene, comparison: Comparison, pairs: Sequence[Pair]) -> Table:
    """The best mapping of each competing feature set, the best set first."""
    layers, exists = comparison.at(pairs)
    members = competing_sets(comparison, pairs, exists)
    rows, columns, turned = task.source.ids, target.ids, len(task.source.ids) > len(target.ids)
    if turned:
        rows, columns, layers, pairs = columns, rows, layers.transpose(0, 2, 1), [(c, r) for r, c in pairs]
    table = Table("feature set", "V / (n |f|)", "its best mapping", title="the paper's rule (eq. 3, 4)")
    if not rows:
        return table
    race = Competition(layers, members, pairs, comparison.config.tie_tolerance)
    for f in sorted(range(len(members)), key=lambda f: -race.solve(f)[0]):
        value, best = race.solve(f)
        mapping = [(r, columns[c]) for r, c in zip(rows, race.expand(best), strict=True) if c != UNMAPPED]
        shown = " ".join(f"{t}→{r}" if turned else f"{r}→{t}" for r, t in mapping)
        table.add_row(" + ".join(FEATURES[k] for k in members[f].nonzero()[0]), f"{value:.4f}", shown)
    return table


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; 0 when it worked."""
    parser = CommandParser(prog="explain", description=__doc__)
    parser.add_argument("--strategy", choices=sorted(STRATEGIES), default="mbd")
    parser.add_argument("--example", choices=list(EXAMPLES), default="by_hand", help="which one, without --folder")
    parser.add_argument("--folder", type=Path, help="the study folder data/hri17")
    parser.add_argument("--session", help="one of its sessions, such as u2_t0")
    parser.add_argument("--assists", type=int, help="how many of the assists to use; all by default")
    options = parser.parse_args(arguments)
    if (options.folder is None) != (options.session is None):
        parser.error("--folder and --session go together")
    example = EXAMPLES[options.example]()
    task, target, assists = example.task, example.target, example.assists
    try:
        if options.folder is not None:
            found = [s for s in read_study(options.folder) if s.name == options.session]
            if not found:
                raise MbdError(f"no session '{options.session}' in {options.folder}; expected a name such as u2_t0")
            task, target, assists = found[0].task, found[0].target, found[0].assists
    except MbdError as error:
        sys.stderr.write(f"explain: {error}\n")
        return 1
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 110)
    given = assists if options.assists is None else assists[: options.assists]
    if options.folder is None:
        console.print(example.about)
    explain(task, target, given, MappingConfig(strategy=options.strategy), console)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
