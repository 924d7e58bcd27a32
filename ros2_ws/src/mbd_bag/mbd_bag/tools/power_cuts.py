"""``power_cuts``: record at a session's rate, cut the power at random moments (simulated), print what each costs."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero, at_least_one
from rich.console import Console

from mbd_bag.recorder.power_cuts import power_cuts
from mbd_bag.session.command_line import run_tool

_ALLOWED = 2.0  # [s] that a power cut may cost


def _tool() -> int:
    parser = CommandParser(prog="power_cuts", description=__doc__)
    parser.add_argument("--cuts", type=at_least_one, default=1000, help="number of power cuts (default 1000)")
    parser.add_argument("--seconds", type=above_zero, default=60.0, help="to record, 4 at least (default 60)")
    parser.add_argument(
        "--picture", type=at_least_one, default=180_000, help="size of a picture [byte] (default 180000)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the moments (default 1)")
    parser.add_argument("--folder", type=Path, help="where to write, on the disk in question (default: temporary)")
    arguments = parser.parse_args()
    if arguments.cuts < 1 or arguments.seconds < 4.0 or arguments.picture < 1:
        parser.error("--cuts and --picture are 1 at least, --seconds 4 at least")
    rng = np.random.default_rng(arguments.seed)
    with TemporaryDirectory(prefix="mbd_power_cuts_", dir=arguments.folder) as folder:
        done = power_cuts(Path(folder) / "bag", arguments.cuts, arguments.seconds, rng, picture=arguments.picture)
    losses = np.array([cut.loss for cut in done])
    low, middle, high, most = np.quantile(losses, (0.05, 0.5, 0.95, 1.0))
    within = int((losses <= _ALLOWED).sum())
    Console().print(
        f"{len(done)} power cuts in {arguments.seconds:g} s (seed {arguments.seed}): lost were {middle:.2f} s in the "
        f"median, {low:.2f} to {high:.2f} s in nine of ten, {most:.2f} s at most; {within} of {len(done)} at most "
        f"{_ALLOWED:g} s",
        highlight=False,
        soft_wrap=True,
    )
    return 0 if within == len(done) else 1


def main() -> None:
    """Entry point: exit code 0 when no cut costs more than 2 s, 1 otherwise, 2 for what cannot be used."""
    run_tool("power_cuts", _tool)
