"""``rehearse_study OUT``: a study from its plan to its figures, held by simulated people; goes on where it stopped."""

from __future__ import annotations

import subprocess
import sys
import time
from argparse import Namespace
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from mbd_bag.session.command_line import run_tool
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one, zero_to_one
from mbd_model.errors import MbdError
from mbd_model.folders import make_folder
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_model.share_folder import config_folder
from mbd_study.plan.protocol import Deviation, HeldSession, deviations, fidelity, held_sessions, read_reasons
from mbd_study.plan.schedule import planned_sessions
from mbd_study.plan.study_plan import StudyPlan, read_plan
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from mbd_experiments.rehearsal.holding import SlipRates
from mbd_experiments.rehearsal.rehearsal_page import RehearsedRow, rehearsal_page
from mbd_experiments.rehearsal.rehearsal_tasks import rehearsal_tasks
from mbd_experiments.rehearsal.rehearsed_session import RehearsalTask, hold
from mbd_experiments.simulated_participants.study import Finished, is_finished

PLAN = """# Of a rehearsal: two conditions, three tasks. Change it, or give a plan of your own by --plan.
study: rehearsal
seed: {seed}
conditions: [mbd, evidence]
tasks: [stacking, sorting, lunch_packing]
participants: {participants}
arguments:
  mbd: ["strategy:=mbd"]
  evidence: ["strategy:=evidence"]
"""
PARTICIPANTS = 12


def _hold_all(tasks: Sequence[RehearsalTask], out: Path, executor: Executor, console: Console) -> int:
    """Hold what is not held yet; returns how many sessions failed."""
    sessions = out / "sessions"
    make_folder(sessions)
    left = [task for task in tasks if not is_finished(sessions / task.name / "bag")]
    scenes, knowledge = config_folder("mbd_cell"), config_folder("mbd_perception") / "knowledge.yaml"
    work = partial(hold, out=sessions.absolute(), scenes=scenes.absolute(), knowledge=knowledge.absolute())
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    failed = 0
    with Progress(*columns, console=console) as progress:
        bar = progress.add_task("sessions", total=len(tasks), completed=len(tasks) - len(left))
        for task, result in zip(left, executor.run_all(work, left, lambda task: task.name), strict=True):
            if isinstance(result, Finished):
                text = f"{task.name}: {task.intention.words}; {result.simulated:.0f} s in {result.wall:.0f} s"
                text += "".join(f"; laid again: {trouble}" for trouble in result.troubles)
            else:
                failed += 1
                text = f"{task.name}: {result}"
            progress.console.print(escape(text), highlight=False, soft_wrap=True)
            progress.advance(bar)
    return failed


def _run(console: Console, module: str, *words: str) -> bool:
    """Run one of our tools, its output on this terminal; whether it ended well."""
    command = [sys.executable, "-c", f"from {module} import main; main()", *words]
    ended = subprocess.run(command, check=False)
    if ended.returncode:
        console.print(f"[yellow]{module} ended with code {ended.returncode}[/]; the rest goes on")
    return ended.returncode == 0


def _evaluate(out: Path, plan: Path, reports: bool, jobs: str, console: Console) -> bool:
    """Tables, analysis, the paper's experiments, a report a session; whether all of it ended well."""
    sessions = str(out / "sessions")
    steps: list[tuple[Path, str, tuple[str, ...]]] = [
        (out / "tables", "mbd_study.tables.export", (sessions, "--out", str(out / "tables"), *jobs.split())),
        (
            out / "analysis",
            "mbd_study.analysis.analyse_command",
            (str(out / "tables"), "--plan", str(plan), "--out", str(out / "analysis")),
        ),
    ]
    steps += [
        (
            out / f"experiment{number}",
            f"mbd_experiments.user_study.experiment{number}",
            (sessions, "--out", str(out / f"experiment{number}"), *jobs.split()),
        )
        for number in (2, 3)
    ]
    if reports:
        make_folder(out / "reports")
        for bag in sorted((out / "sessions").glob("*/bag")):
            page = out / "reports" / f"{bag.parent.name}.html"
            steps.append((page, "mbd_study.figures.report", (str(bag), "--out", str(page))))
    well = True
    for made, module, words in steps:
        if not made.exists():
            well = _run(console, module, *words) and well
    return well


def _write_page(out: Path, plan: StudyPlan, seconds: float, console: Console) -> bool:
    """The study's page; whether every session kept the plan, or its bag states why not."""
    sessions = out / "sessions"
    held, problems = held_sessions(sessions)
    planned = planned_sessions(plan)
    found = deviations(planned, held, read_reasons(sessions))
    share = fidelity(planned, held, found) or 0.0
    recorded = sum(bool(d.reason) for d in found)
    facts = [
        ("sessions", f"{len(held)} of {len(planned)} held, {len(plan.participants)} participants"),
        ("plan kept, or deviation recorded", f"{100 * share:.0f} % of the sessions"),
        ("deviations", f"{len(found)}, {recorded} of them recorded"),
        ("wrong clicks", _slips(out)),
        ("time", f"{seconds:.0f} s for what this run did"),
        *(("problem", problem) for problem in problems),
    ]
    analysis = out / "analysis" / "analysis.md"
    text = analysis.read_text(encoding="utf-8") if analysis.exists() else ""
    page = rehearsal_page(f"Study {plan.study}", facts, _rows(held, found, out), out, text)
    (out / "index.html").write_text(page, encoding="utf-8")
    for name, value in facts:
        console.print(f"{name}: {value}", highlight=False, soft_wrap=True, markup=False)
    console.print(f"page: {out / 'index.html'}", highlight=False, soft_wrap=True, markup=False)
    return share == 1.0 and len(held) == len(planned)


def _slips(out: Path) -> str:
    from mbd_bag.storage.bag_metadata import read_metadata

    counts = {"objects": 0, "buttons": 0}
    for bag in (out / "sessions").glob("*/bag"):
        facts = read_metadata(bag).get("custom_data", {})
        for name in counts:
            counts[name] += int(facts.get(f"operator.wrong_{name}", 0))
    return f"{counts['objects']} on another object, {counts['buttons']} on another button"


def _rows(held: Sequence[HeldSession], found: Sequence[Deviation], out: Path) -> list[RehearsedRow]:
    said: dict[str, list[str]] = {}
    for deviation in found:
        text = f"{deviation.what} ({deviation.reason or 'not recorded'})"
        said.setdefault(deviation.session, []).append(text)
    rows = []
    for one in held:
        report = out / "reports" / f"{one.session}.html"
        phase = one.phase.name.lower() if one.phase is not None else ""
        rows.append(
            RehearsedRow(
                session=one.session,
                participant=one.participant,
                condition=one.condition,
                task=one.task,
                phase=phase,
                deviation="; ".join(said.get(one.session, [])),
                report=report if report.exists() else None,
            )
        )
    return rows


def _arguments() -> Namespace:
    parser = CommandParser(prog="rehearse_study", description=__doc__)
    parser.add_argument("out", type=Path, help="folder of the study; of an earlier run to go on with it")
    parser.add_argument("--plan", type=Path, help="plan.yaml (default: 2 conditions, 3 tasks)")
    parser.add_argument(
        "--participants", type=at_least_one, default=PARTICIPANTS, help=f"without --plan (default {PARTICIPANTS})"
    )
    parser.add_argument("--seed", type=int, default=1, help="of everything")
    parser.add_argument(
        "--misclicks", type=zero_to_one, default=0.05, help="share of the operator's clicks (default 0.05)"
    )
    parser.add_argument("--reports", action="store_true", help="a page a session too (some seconds each)")
    add_executor_options(parser, "sessions")
    return parser.parse_args()


def _tool() -> int:
    arguments, console, started = _arguments(), Console(), time.perf_counter()
    if arguments.participants < 1 or arguments.seed < 0:
        raise MbdError("a rehearsal needs 1 participant or more, and a seed from 0 on")
    out: Path = arguments.out.absolute()
    if out.is_dir() and any(out.iterdir()) and not (out / "plan.yaml").exists():
        raise MbdError(f"{out} holds other things than a rehearsal; give a folder of its own")
    if arguments.plan is not None:
        read_plan(arguments.plan)  # refused before a folder is made
    make_folder(out)
    text = (
        arguments.plan.read_text(encoding="utf-8")
        if arguments.plan is not None
        else PLAN.format(seed=arguments.seed, participants=arguments.participants)
    )
    path = out / "plan.yaml"
    if path.exists() and path.read_text(encoding="utf-8") != text:
        raise MbdError(f"{path} is the plan of another rehearsal; give another folder, or what that was begun with")
    path.write_text(text, encoding="utf-8")
    plan = read_plan(path)
    tasks = rehearsal_tasks(plan, SlipRates(click=arguments.misclicks), arguments.seed)
    failed = _hold_all(tasks, out, executor_of(arguments), console)
    if failed:
        console.print(f"[red]{failed} sessions failed[/]; the same line again tries them once more")
        return 1
    jobs = f"--jobs {arguments.jobs}" if getattr(arguments, "jobs", None) else ""
    well = _evaluate(out, path, arguments.reports, jobs, console)
    kept = _write_page(out, plan, time.perf_counter() - started, console)
    return 0 if well and kept else 1


def main() -> None:
    """Entry point: exit code 0 when the plan was kept or each deviation recorded, 1 when not, 2 when it cannot be."""
    run_tool("rehearse_study", _tool)
