"""`ros2 run mbd_experiments case_studies`: the case studies (paper sec. 5.1), after each assist as in Table 3."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from mbd_mapping.inference import STRATEGIES
from mbd_model.command_line.parser import CommandParser
from rich.console import Console
from rich.table import Table

from mbd_experiments.simulated_problems.case_studies import case_studies, predictions


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; 0 when it worked."""
    parser = CommandParser(prog="case_studies", description=__doc__)
    parser.add_argument("--strategy", choices=[*sorted(STRATEGIES), "both"], default="both")
    options = parser.parse_args(arguments)
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 110)
    for study in case_studies():
        for strategy in sorted(STRATEGIES) if options.strategy == "both" else [options.strategy]:
            table = Table(
                "assists", "predictions", "correct", "confidence", "winning", title=f"{study.name}, {strategy}"
            )
            for count, line in enumerate(predictions(study, strategy)):
                winning = " + ".join(line.estimate.winning)
                table.add_row(
                    str(count), str(line.predictions), str(line.correct), f"{line.estimate.confidence:.3f}", winning
                )
            console.print(table)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
