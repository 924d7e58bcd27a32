"""``table5_readings FOLDER``: what the paper may have counted as consistent in its Table 5, and which of it can be.

The paper gives no criterion. Each way of judging demonstrations is put together with each way of judging assists, from
the raw hints of the study folder. Of the complete folder a reading gives the paper's cells or not. Of a part of it a
reading is possible when the sessions that are not there could make up the rest.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mbd_bag.session.command_line import run_tool
from mbd_mapping.inference import infer
from mbd_model.command_line.parser import CommandParser
from rich.console import Console
from rich.table import Table

from mbd_experiments.public_study.study_folder import SESSION, StudySession, read_study, used_assists
from mbd_experiments.user_study.import_study import STUDY_CONFIG
from mbd_experiments.user_study.study_facts import REAL_SCRIPTS, TASK_NAMES, Pairs

PARTICIPANTS = 10
# Consistent demonstrations, assists, both. The paper has 6 for stacking; its public records are said to give 5.
CELLS = {"stacking": ((6, 7, 4), (5, 7, 4)), "sorting": ((6, 6, 5),), "lunch_packing": ((8, 10, 8),)}
Judge = Callable[[StudySession, Pairs], bool]


def _flat(pairs: Pairs) -> list[str]:
    return [name for pair in pairs for name in pair]


def _paired(names: Sequence[str]) -> Pairs:
    return tuple(zip(names[0::2], names[1::2], strict=False))


def _shown(session: StudySession) -> Pairs:
    """(picked, placed onto) as recorded."""
    return _paired([step.primary_object for step in session.task.steps])


def _right(session: StudySession, asked: Sequence[str], hints: Sequence[str]) -> bool:
    """Whether each hint is right for the object asked about with it."""
    return all(hint in session.solution.get(name, ()) for name, hint in zip(asked, hints, strict=False))


def _carries_out(session: StudySession, script: Pairs) -> bool:
    """Whether the hints, two by two, are all right for a pair of the script, and every pair has some."""

    def fits(pair: tuple[str, str], hints: tuple[str, str]) -> bool:
        return _right(session, pair, hints)

    given = _paired(session.hints)
    return all(any(fits(p, g) for p in script) for g in given) and all(any(fits(p, g) for g in given) for p in script)


def _as_recorded(session: StudySession, _script: Pairs) -> bool:
    return _right(session, [step.primary_object for step in session.task.steps], session.hints)


def _as_recorded_once(session: StudySession, _script: Pairs) -> bool:
    return _right(session, [step.primary_object for step in session.task.steps], used_assists(session.hints))


DEMONSTRATIONS: Mapping[str, Judge] = {
    "script's order": lambda session, script: _shown(session) == script,
    "any order": lambda session, script: Counter(_shown(session)) == Counter(script),
    "every pair, and more": lambda session, script: set(script) <= set(_shown(session)),
    "picks in order": lambda session, script: [p for p, _ in _shown(session)] == [p for p, _ in script],
    "objects used": lambda session, script: set(session.task.used_objects) == set(_flat(script)),
}
ASSISTS: Mapping[str, Judge] = {
    "each, as recorded": _as_recorded,
    "each, as recorded, repeats left out": _as_recorded_once,
    "each, as scripted": lambda session, script: _right(session, _flat(script), session.hints),
    "each, as scripted, repeats left out": lambda s, script: _right(s, _flat(script), used_assists(s.hints)),
    "each, as recorded or as scripted, repeats left out": lambda s, script: (
        _as_recorded_once(s, script) or _right(s, _flat(script), used_assists(s.hints))
    ),
    "first two": lambda session, script: _right(session, _flat(script), session.hints[:2]),
    "two by two, in any order": _carries_out,
}


@dataclass(frozen=True)
class TableReading:
    """One way of judging, over one task.

    Attributes:
        task: its name.
        order: of the script's picks.
        demonstrations, assists: how they are judged.
        cells: consistent demonstrations, assists, both.
        mapped: of the latter those whose mapping is right with all assists, by the paper's rule.
        sessions: looked at.
        possible: whether the paper's cells, or those said of its public records, can come out.
    """

    task: str
    order: tuple[str, ...]
    demonstrations: str
    assists: str
    cells: tuple[int, int, int]
    mapped: int
    sessions: int
    possible: bool


def can_become(cells: tuple[int, int, int], sessions: int, wanted: tuple[int, int, int]) -> bool:
    """Whether the sessions missing from ten could bring ``cells`` of so many sessions to those wanted."""
    shown, assists, both = (w - c for w, c in zip(wanted, cells, strict=True))
    missing = PARTICIPANTS - sessions
    return min(shown, assists, both) >= 0 and both <= min(shown, assists) and shown + assists - both <= missing


def readings(sessions: Sequence[StudySession]) -> Iterator[TableReading]:
    """Every way of judging for every task, in each order in which somebody did it."""
    mapped = {}
    for session in sessions:
        end = infer(session.task, session.target, session.assists, STUDY_CONFIG)
        mapped[session.name] = session.solved_by(end.mapping.as_dict)
    for number, task in enumerate(TASK_NAMES):
        own = [s for s in sessions if (match := SESSION.fullmatch(s.name)) and int(match[2]) == number]
        known = REAL_SCRIPTS[task]
        orders = dict.fromkeys([known, *(_shown(s) for s in own if Counter(_shown(s)) == Counter(known))])
        for script, shown, given in itertools.product(orders, DEMONSTRATIONS, ASSISTS):
            right = {s.name for s in own if DEMONSTRATIONS[shown](s, script)}
            helped = {s.name for s in own if ASSISTS[given](s, script)}
            cells = len(right), len(helped), len(right & helped)
            yield TableReading(
                task=task,
                order=tuple(picked for picked, _ in script),
                demonstrations=shown,
                assists=given,
                cells=cells,
                mapped=sum(mapped[name] for name in right & helped),
                sessions=len(own),
                possible=any(can_become(cells, len(own), wanted) for wanted in CELLS[task]),
            )


def possible_of(found: Sequence[TableReading]) -> list[tuple[TableReading, ...]]:
    """The ways of judging that are possible for every task: a reading of each, sorting in each order that is."""
    ways = []
    for shown, given in itertools.product(DEMONSTRATIONS, ASSISTS):
        own = [r for r in found if (r.demonstrations, r.assists) == (shown, given) and r.possible]
        by_task = [[r for r in own if r.task == task] for task in TASK_NAMES]
        ways += list(itertools.product(*by_task))
    return ways


def _tool() -> int:
    parser = CommandParser(prog="table5_readings", description=__doc__)
    parser.add_argument("folder", type=Path, help="the public study folder, data/hri17")
    parser.add_argument("--all", action="store_true", help="also what is not possible")
    arguments = parser.parse_args()
    found = list(readings(read_study(arguments.folder)))
    console = Console()
    if arguments.all:
        table = Table("task", "order", "demonstrations", "assists", "cells", "mapped", "possible", box=None)
        for r in found:
            cells = " / ".join(map(str, r.cells))
            order = " ".join(name.rpartition("_")[2] if r.task == "sorting" else name for name in r.order)
            table.add_row(
                r.task, order, r.demonstrations, r.assists, f"{cells} of {r.sessions}", f"{r.mapped}", str(r.possible)
            )
        console.print(table)
    ways = possible_of(found)
    table = Table("demonstrations", "assists", *TASK_NAMES, "both, mapped", "sorted in the order", box=None)
    for way in ways:
        table.add_row(
            way[0].demonstrations,
            way[0].assists,
            *(" / ".join(map(str, r.cells)) for r in way),
            f"{sum(r.cells[2] for r in way)}, {sum(r.mapped for r in way)}",
            " ".join(name.rpartition("_")[2] for name in way[1].order),
        )
    sessions = " + ".join(str(next(r.sessions for r in found if r.task == task)) for task in TASK_NAMES)
    console.print(f"{len(ways)} ways of judging give the paper's Table 5, or could, on {sessions} sessions")
    console.print(table)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the folder cannot be used."""
    run_tool("table5_readings", _tool)
