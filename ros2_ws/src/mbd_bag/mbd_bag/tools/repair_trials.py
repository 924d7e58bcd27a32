"""``repair_trials BAG…``: damage copies of bags at random, repair them, and print what share of the intact is kept."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one
from rich.console import Console
from rich.progress import track

from mbd_bag.repairing.trials import mcap_trials, sqlite_trials
from mbd_bag.session.command_line import run_tool
from mbd_bag.storage.bag_paths import bags_below


def _tool() -> int:
    parser = CommandParser(prog="repair_trials", description=__doc__)
    parser.add_argument("bags", type=Path, nargs="+", help="intact bags of one MCAP file each, or folders of them")
    parser.add_argument("--sqlite3", action="store_true", help="store them as sqlite3 (.db3) before")
    parser.add_argument("--number", type=at_least_one, default=1000, help="bags to damage (default 1000)")
    parser.add_argument("--seed", type=int, default=1, help="of the damage (default 1)")
    arguments = parser.parse_args()
    console = Console()
    with TemporaryDirectory(prefix="mbd_repair_trials_") as folder:
        trials_of = sqlite_trials if arguments.sqlite3 else mcap_trials
        trials = trials_of(bags_below(arguments.bags), arguments.number, arguments.seed, Path(folder))
        done = list(track(trials, "repairing", arguments.number, console=console, transient=True))
    intact, kept = sum(t.intact for t in done), sum(t.kept for t in done)
    altered = f"; {sum(t.altered for t in done)} messages altered by bytes that no checksum covers" * arguments.sqlite3
    parts = "pages" if arguments.sqlite3 else "chunks"
    console.print(
        f"{len(done)} bags with 1 to 20 bytes flipped each, half of them also cut (seed {arguments.seed}): "
        f"{kept} of {intact} messages in intact {parts} kept ({kept / max(intact, 1):.4%}), "
        f"of {sum(t.messages for t in done)} in all; {sum(t.invented for t in done)} invented; "
        f"the damage was noticed in {sum(t.noticed for t in done)}{altered}",
        highlight=False,
        soft_wrap=True,
    )
    for trial in done:
        if trial.failure or trial.invented:
            console.print(
                f"  {trial.damage}: {trial.failure or 'invented'}", highlight=False, soft_wrap=True, markup=False
            )
    return 0 if kept >= 0.999 * intact and not any(t.invented or t.failure for t in done) else 1


def main() -> None:
    """Entry point: exit code 0 when at least 99.9 % is kept and nothing invented, 1 otherwise, 2 for bad bags."""
    run_tool("repair_trials", _tool)
