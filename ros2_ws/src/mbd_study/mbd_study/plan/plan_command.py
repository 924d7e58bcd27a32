"""``plan PLAN``: check a study's plan and print its sessions; with ``--sessions``: which is next, and deviations."""

from __future__ import annotations

import csv
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import fields
from datetime import UTC, datetime
from pathlib import Path

from mbd_bag.session.command_line import note, run_tool
from mbd_model.command_line.parser import CommandParser
from mbd_model.parameters import nearest
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_study.plan.protocol import (
    Deviation,
    HeldSession,
    deviations,
    fidelity,
    held_sessions,
    next_session,
    read_reasons,
    record_reason,
)
from mbd_study.plan.schedule import PlannedSession, imbalances, planned_sessions
from mbd_study.plan.study_plan import PlanError, StudyPlan, read_plan

UNRECORDED = 1


def write_schedule(planned: Sequence[PlannedSession], path: Path) -> None:
    """Write the sessions as CSV, a column for each field; raises PlanError when it exists or cannot be written."""
    try:
        with path.open("x", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(f.name for f in fields(PlannedSession))
            for one in planned:
                cells = (one.session, one.participant, one.position, one.condition, one.task, one.seed)
                writer.writerow((*cells, " ".join(one.arguments)))
    except FileExistsError as error:
        raise PlanError(f"{path} exists already and is not overwritten; choose another --out") from error
    except OSError as error:
        raise PlanError(f"{path} cannot be written: {error.strerror}; choose another --out") from error


def _table(planned: Sequence[PlannedSession], held: Sequence[HeldSession], found: Sequence[Deviation]) -> Table:
    """A row for each participant: the sessions in order; those held are marked by "+", deviations by "!"."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("participant", no_wrap=True)
    table.add_column("condition and task, in order")
    marks = {h.session: "+" for h in held} | {d.session: "!" for d in found}
    rows: dict[str, list[str]] = {}
    for one in planned:
        mark = marks.get(one.session, "")
        rows.setdefault(one.participant, []).append(f"{mark}{one.condition}/{one.task}")
    for participant, cells in rows.items():
        table.add_row(participant, escape("  ".join(cells)))
    return table


def _print_next(plan: StudyPlan, one: PlannedSession | None, arguments: Namespace, console: Console) -> None:
    participant, path, folder = arguments.participant, arguments.plan, arguments.sessions
    if one is None:
        console.print(f"next: none; every session {f'of {participant} ' if participant else ''}was held or given up")
        return
    number = plan.participants.index(one.participant) + 1
    words = (f"session:={one.session}", f"participant:={one.participant}", f"task:={one.task}", *one.arguments)
    led = f"./mbd run mbd_bringup session --plan {path} --folder {folder or 'sessions'} --console"
    console.print(
        f"next: {one.session} (participant {number} of {len(plan.participants)}, session {one.position}, condition "
        f"{one.condition}, seed {one.seed})\n  {led}\n  ros2 launch mbd_bringup session.launch.py {' '.join(words)}",
        highlight=False,
        soft_wrap=True,
        markup=False,
    )


def _report(plan: StudyPlan, planned: Sequence[PlannedSession], arguments: Namespace, console: Console) -> int:
    """The plan beside what was held; returns the exit code."""
    folder: Path = arguments.sessions
    held, problems = held_sessions(folder)
    for problem in problems:
        note(problem, console)
    if arguments.record:
        session, reason = arguments.record
        known = [p.session for p in planned] + [h.session for h in held]
        if session not in known:
            near = nearest(session, known)
            hint = f"did you mean {near!r}?" if near else "`plan PLAN` prints the names"
            raise PlanError(f"session {session!r} is neither planned nor held; {hint}")
        record_reason(folder, session, reason, datetime.now(UTC).isoformat(timespec="seconds"))
    reasons = read_reasons(folder)
    found = deviations(planned, held, reasons)
    console.print(_table(planned, held, found))
    names = {p.session for p in planned}
    console.print(f"{sum(h.session in names for h in held)} of {len(planned)} sessions held", highlight=False)
    for one in found:
        state = f"recorded: {one.reason}" if one.reason else "NOT recorded; state why by --record SESSION REASON"
        text = f"deviation: {one.session}: {one.what} ({state})"
        console.print(text, highlight=False, markup=False, soft_wrap=True)
    share = fidelity(planned, held, found)
    if share is not None:
        console.print(f"plan kept or deviation recorded in {100 * share:.0f} % of the sessions", highlight=False)
    _print_next(plan, next_session(planned, held, reasons, arguments.participant), arguments, console)
    return UNRECORDED if any(not d.reason for d in found) else 0


def _tool() -> int:
    parser = CommandParser(prog="plan", description=__doc__)
    parser.add_argument("plan", type=Path, help="the study's plan.yaml")
    parser.add_argument("--sessions", type=Path, metavar="FOLDER", help="of the bags held so far")
    parser.add_argument("--participant", default="", help="the next session of this one")
    parser.add_argument(
        "--record", nargs=2, metavar=("SESSION", "REASON"), help="why the plan was left, kept in FOLDER/deviations.csv"
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the sessions as CSV, too")
    arguments = parser.parse_args()
    console = Console()
    plan = read_plan(arguments.plan)
    planned = planned_sessions(plan)
    if arguments.participant and arguments.participant not in plan.participants:
        near = nearest(arguments.participant, plan.participants)
        hint = f"did you mean {near!r}?" if near else f"expected one of {', '.join(plan.participants)}"
        raise PlanError(f"participant {arguments.participant!r} is not in the plan; {hint}")
    if arguments.record and arguments.sessions is None:
        raise PlanError("--record keeps the reason in the folder of the sessions; give it by --sessions FOLDER")
    if arguments.out is not None:
        write_schedule(planned, arguments.out)
    console.print(
        f"study {plan.study}: {len(plan.participants)} participants, {len(plan.conditions)} conditions "
        f"({plan.condition_order}), {len(plan.tasks)} tasks ({plan.task_order}), {len(planned)} sessions, "
        f"seed {plan.seed}",
        highlight=False,
        soft_wrap=True,
        markup=False,
    )
    for sentence in imbalances(plan):
        note(sentence, console)
    if arguments.sessions is not None:
        return _report(plan, planned, arguments, console)
    console.print(_table(planned, (), ()))
    _print_next(plan, next_session(planned, (), {}, arguments.participant), arguments, console)
    return 0


def main() -> None:
    """Entry point: exit code 0; 1 when a deviation is not recorded; 2 when the plan cannot be used."""
    run_tool("plan", _tool)
