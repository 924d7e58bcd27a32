"""``make demo``: one complete study session in the simulated cell, recorded, replayed and drawn."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from datetime import datetime
from errno import EACCES
from pathlib import Path

from ament_index_python.packages import get_package_prefix
from mbd_bag.session.command_line import open_session
from mbd_cell.outcome import PlaceOutcome
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero, zero_or_more, zero_to_one
from mbd_model.errors import MbdError
from mbd_model.session import Phase
from mbd_study.recompute.both_strategies import strategies_table, strategy_rows
from rich.console import Console
from rich.markup import escape

from mbd_bringup.nodes import GRASPS, STRATEGIES, SessionOptions
from mbd_bringup.ros.event_lines import print_event
from mbd_bringup.ros.live_session import LiveSession

TASKS = ("stacking", "sorting", "lunch_packing", "dish_sorting", "assembly")


def parse_arguments(words: Sequence[str] | None = None) -> argparse.Namespace:
    """The command line of the demo."""
    parser = CommandParser(prog="demo", description=__doc__)
    parser.add_argument("--task", choices=TASKS, default="sorting")
    parser.add_argument("--seed", type=int, default=1, help="of every random choice in the cell (default 1)")
    parser.add_argument(
        "--strategy", choices=STRATEGIES, default="evidence", help="of the mapping: evidence, or mbd (the paper's rule)"
    )
    parser.add_argument(
        "--threshold", type=zero_to_one, help="confidence from which it goes on alone (default: the strategy's)"
    )
    parser.add_argument(
        "--speed", type=zero_or_more, default=0.0, help="simulated over real time; 0: as fast as possible"
    )
    parser.add_argument(
        "--grasp",
        choices=GRASPS,
        default="friction",
        help="what keeps an object in the hand (docs/cell.md; default friction; weld: computed sooner, loses nothing)",
    )
    parser.add_argument(
        "--execute",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="the robot executes the task on the new objects; else it only states what it would do",
    )
    parser.add_argument("--robot", default="", help="the cell plays this robot: jaco2, gen3, ... or a file")
    parser.add_argument("--camera", default="", help="the same of a camera: realsense, zed, ... or a file")
    parser.add_argument("--out", type=Path, help="folder of the session (default sessions/TASK_seedN_TIME)")
    parser.add_argument("--timeout", type=above_zero, default=600.0, help="give up after so many seconds (default 600)")
    return parser.parse_args(words)


def session_options(arguments: argparse.Namespace, now: datetime) -> SessionOptions:
    """Options of the demo's session; raises MbdError for a value out of its range or a folder that is in use."""
    name = f"{arguments.task}_seed{arguments.seed}_{now:%Y%m%d_%H%M%S}"
    folder = (arguments.out or Path("sessions") / name).resolve()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        used = any(folder.iterdir())
        if not os.access(folder, os.W_OK):
            raise PermissionError(EACCES, "it may not be written to")
    except OSError as error:
        raise MbdError(
            f"--out {folder} cannot hold a session ({error.strerror}): give a folder that this user may write"
        ) from error
    if used:
        raise MbdError(f"{folder} already holds a session, and none is ever overwritten; give another --out")
    return SessionOptions(
        session=name,
        folder=folder,
        task=arguments.task,
        seed=arguments.seed,
        strategy=arguments.strategy,
        threshold=arguments.threshold,
        speed=arguments.speed,
        grasp=arguments.grasp,
        participant="simulated",
        execute=arguments.execute,
        robot=arguments.robot,
        camera=arguments.camera,
    )


def run(options: SessionOptions, console: Console, timeout: float) -> Phase | None:
    """Run the session to its end and print what happens; returns the phase it ended in.

    Raises:
        MbdError: a node died or the session took longer than ``timeout`` [s].
    """
    begun = time.monotonic()
    with LiveSession(options) as live, console.status("") as status:
        console.print(
            f"[dim]ROS_DOMAIN_ID={live.domain}; grasps hold by {options.grasp}; "
            f"the nodes' output goes to {live.logs}[/]",
            soft_wrap=True,
        )
        for event in live.events(timeout):
            elapsed = time.monotonic() - begun
            if event is not None:
                print_event(event, elapsed, console)
            where = "starting the nodes" if live.phase is None else live.phase.name.replace("_", " ").lower()
            status.update(f"{where} ... {elapsed:.0f} s, cell time {live.follower.clock_now:.1f} s")
        status.update("closing the bag")
        killed = live.processes.stop(patience=20.0)
    if options.execute:
        print_ending(live.follower.ending.places(), console)
    if killed:
        console.print(f"[red]did not end by themselves and were killed: {', '.join(killed)}[/]")
    return live.phase


def print_ending(places: Sequence[PlaceOutcome], console: Console) -> None:
    """Print whether each object ended where it should, judged by the cell's true poses."""
    right = sum(p.success for p in places)
    console.rule(f"[bold cyan]{right} of {len(places)} objects ended where they should[/]", align="left")
    for place in places:
        where = f"with {place.onto}" if place.onto is not None else "on the table"
        verdict = "[green]success[/]" if place.success else f"[red]not: {escape(place.why)}[/]"
        console.print(f"step {place.step + 1:2}  {escape(f'{place.held} {where}'):40} {verdict}", highlight=False)


def _tool(package: str, executable: str, *words: str) -> int:
    """Run one of our own command-line tools, its output on this terminal; returns its exit code."""
    path = Path(get_package_prefix(package)) / "lib" / package / executable
    return subprocess.run([str(path), *words], check=False).returncode


def _interrupt(signum: int, frame: object) -> None:
    raise KeyboardInterrupt


def main() -> None:
    """Entry point: exit code 0 when the session was done and its replay agrees."""
    signal.signal(signal.SIGTERM, _interrupt)
    console = Console()
    try:
        arguments = parse_arguments()
        options = session_options(arguments, datetime.now())
        phase = run(options, console, arguments.timeout)
        code = report(options, phase, console)
    except KeyboardInterrupt:
        console.print("[red]interrupted[/]: every node was ended; what was recorded is in the session's bag")
        sys.exit(130)
    except MbdError as error:
        console.print(f"[red]demo:[/] {escape(str(error))}", highlight=False)
        sys.exit(1)
    sys.exit(code)


def report(options: SessionOptions, phase: Phase | None, console: Console) -> int:
    """Table, picture and replay of the recorded session; returns the exit code."""
    bag = str(options.bag)
    picture = options.folder / "mapping.png"
    console.rule("[bold cyan]what happened[/]", align="left")
    table = _tool("mbd_study", "table", bag)
    rows = strategy_rows(open_session(options.bag)[1])
    console.print(strategies_table(rows))
    drawn = _tool("mbd_study", "picture", bag, "--out", str(picture))
    console.rule("[bold cyan]offline replay of the bag[/]", align="left")
    replayed = _tool("mbd_study", "replay", bag, "--check")
    console.print(f"bag:     {options.bag}\npicture: {picture}", highlight=False, soft_wrap=True)
    if phase is not Phase.DONE:
        console.print("[red]the session was not carried to its end[/]")
        return 1
    return max(table, drawn, replayed)
