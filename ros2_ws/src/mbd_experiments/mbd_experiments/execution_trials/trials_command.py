"""How often the robot does a task right to the last object: sessions in the simulated cell, counted.

Each session is complete: objects newly drawn and seen by a noisy camera, a demonstration read off the tool's path, the
mapping inferred from it and the teacher's answers, and the task executed. Nothing of the truth reaches the robot. In
--out there are a result for each trial, trials.csv and summary.csv, and of each failed trial a bag, a picture and a
sentence; started again with the same --out, the command goes on where it stopped.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from mbd_bag.session.command_line import run_tool
from mbd_cell.adversary import TableDisturbance
from mbd_cell.physics.grasp import Grasp
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one, zero_to_one
from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_model.share_folder import config_folder
from rich.console import Console

from mbd_experiments.csv_table import write_csv
from mbd_experiments.execution_trials.result import TASKS, TrialCase, TrialHalf, TrialResult, cases
from mbd_experiments.execution_trials.summary import TrialSummary, summaries
from mbd_experiments.execution_trials.teacher_errors import ERRORS
from mbd_experiments.execution_trials.trials import TrialFolder, run_trials

PRINT = Console(highlight=False, soft_wrap=True)
EACH, EVERY = "each", "every"
HEADINGS = (
    "trials", "right", "assists", "at work", "dropped", "unnoticed", "arm-table", "arm-objects", "robot s", "here s",
)  # fmt: skip


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 0, 1 when fewer sessions than wanted were right, 2 when the trials cannot be run."""
    run_tool("execution_trials", lambda: _tool(words))


def _tool(words: Sequence[str] | None) -> int:
    parser = _parser()
    given = parser.parse_args(words)
    if given.layouts < 1 or given.first < 0:
        parser.error(f"--layouts {given.layouts} --first {given.first}: at least one layout, no negative seed")
    if not 0.0 <= given.wanted <= 1.0:
        parser.error(f"--wanted {given.wanted}: a share from 0 to 1")
    seeds = [s for s in range(given.first, given.first + given.layouts) if given.half in ("all", TrialHalf.of(s))]
    if not seeds:
        parser.error(f"--half {given.half} leaves none of the seeds from {given.first} on; give more --layouts")
    if given.threshold is not None and not 0.0 <= given.threshold <= 1.0:
        parser.error(f"--threshold {given.threshold}: a confidence from 0 to 1")
    adversary = _disturbances(parser, given.adversary)
    errors = tuple(ERRORS[name] for name in _names(parser, "--teacher-errors", given.teacher_errors, list(ERRORS)))
    base = TrialCase("", 0, Grasp(given.grasp), (), errors, given.threshold)
    each = given.adversary != EVERY
    tasks = TASKS if "all" in given.tasks else tuple(dict.fromkeys(given.tasks))
    which = cases(tasks, seeds, adversary, each, base)
    folder = TrialFolder(given.out, config_folder("mbd_cell"), _knowledge(), given.keep_all)
    results = []
    for done, result in enumerate(run_trials(which, folder, executor_of(given)), start=1):
        results.append(result)
        PRINT.print(_line(done, len(which), result), markup=False)
    write_csv(given.out / "trials.csv", [r.row for r in results])
    found = summaries(results)
    write_csv(given.out / "summary.csv", [s.row for s in found])
    conditions = f"grasp by {given.grasp}, {f'adversary {given.adversary}' if adversary else 'undisturbed'}"
    conditions += "" if given.threshold is None else f", alone from a confidence of {given.threshold:g}"
    PRINT.print(
        _table(found, conditions + (f", teacher errors {given.teacher_errors}" if errors else "")), markup=False
    )
    right = found[-1].right
    return 0 if right.hits >= given.wanted * right.of else 1


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="execution_trials", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--tasks", "--task", nargs="+", choices=(*TASKS, "all"), default=["all"], metavar="TASK",
                        help=f"some of {', '.join(TASKS)}, or all (the default)")  # fmt: skip
    parser.add_argument(
        "--layouts", type=at_least_one, default=10, help="seeds a task, counted from --first (default 10)"
    )
    parser.add_argument("--first", type=int, default=1, help="the first seed (default 1)")
    parser.add_argument("--half", choices=(*TrialHalf, "all"), default="all",
                        help="choose: even seeds, which may be looked at while the robot is being made; report: odd "
                        "seeds, only counted; all (the default)")  # fmt: skip
    parser.add_argument("--grasp", choices=[*Grasp], default=str(Grasp.FRICTION),
                        help="what keeps things in the hand: friction (the default), or weld, which is twice as fast "
                        "and loses nothing")  # fmt: skip
    parser.add_argument("--threshold", type=zero_to_one,
                        help="confidence from which the robot goes on alone (default: the strategy's)")  # fmt: skip
    parser.add_argument("--adversary", nargs="?", const=EACH, default="", metavar="WHAT",
                        help=f"somebody disturbs the robot. {EACH} (the default of this option): one disturbance a "
                        f"session, in turn; {EVERY}: all in every session; or some by name, one a session: "
                        f"{','.join(TableDisturbance)}")  # fmt: skip
    parser.add_argument("--teacher-errors", default="", metavar="NAMES",
                        help="errors the teacher may make, at Table 5's rates: all, or some of "
                        f"{','.join(ERRORS)}")  # fmt: skip
    parser.add_argument("--out", type=Path, required=True, help="folder of the results; of an earlier run to go on")
    parser.add_argument("--keep-all", action="store_true", help="keep the bags of trials that went well, too")
    parser.add_argument("--wanted", type=zero_to_one, default=0.0, help="share right below which the exit code is 1")
    add_executor_options(parser, "trials")
    parser.add_argument("--workers", dest="jobs", type=at_least_one, help=argparse.SUPPRESS)
    return parser


def _names(parser: argparse.ArgumentParser, option: str, text: str, known: Sequence[str]) -> list[str]:
    """Names separated by commas, or all of those known."""
    if text == "all":
        return list(known)
    names = [name for name in text.split(",") if name]
    if wrong := sorted(set(names) - set(known)):
        parser.error(f"{option}: {', '.join(wrong)} is none of {', '.join(known)}")
    return names


def _disturbances(parser: argparse.ArgumentParser, text: str) -> tuple[TableDisturbance, ...]:
    known = [str(d) for d in TableDisturbance]
    names = known if text in (EACH, EVERY) else _names(parser, "--adversary", text, known)
    return tuple(TableDisturbance(name) for name in names)


def _knowledge() -> Path:
    return config_folder("mbd_perception") / "knowledge.yaml"


def _line(done: int, total: int, result: TrialResult) -> str:
    return (
        f"{done:3}/{total} {result.task:14} seed {result.seed:3}  {'right' if result.right else 'WRONG'}  "
        f"{result.places_right}/{result.places} places  {result.assists} assists  {result.seconds:4.0f} s of robot  "
        f"{result.wall:4.0f} s here{f'  | {result.disturbed}' if result.disturbed else ''}"
        f"{f'  | {result.why}' if result.why else ''}"
    )


def _table(found: Sequence[TrialSummary], conditions: str) -> str:
    """For people, in columns: a terminal or a file of any width takes it."""
    lines = [f"Sessions right to the last object, 95 % intervals (Wilson); {conditions}", _columns(*HEADINGS)]
    for one in found:
        counts = (one.dropped, one.unnoticed, one.arm_table, one.arm_objects)
        means = (f"{one.assists:.2f}", f"{one.at_work:.2f}"), (f"{one.seconds:.0f}", f"{one.wall:.0f}")
        lines.append(_columns(one.name, one.right.words, *means[0], *map(str, counts), *means[1]))
    return "\n".join(lines)


def _columns(name: str, right: str, *numbers: str) -> str:
    return f"{name:<15}{right:<28}" + "".join(f"{n:>12}" for n in numbers)


if __name__ == "__main__":
    main()
