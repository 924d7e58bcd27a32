"""``answers FOLDER``: the sheet on which an experimenter writes which mapping of a real session is right.

A simulated cell records its truth; people do not. ``answers.csv`` beside the bags has a row for each source object of
each session: ``session, source, looks, right, placed_onto``. ``right`` holds the target ids that may play its role,
``placed_onto`` the source object onto which the participant was asked to place it (empty: it was not to be picked up).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import run_tool
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag_paths import bags_below
from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError
from rich.console import Console
from rich.markup import escape

from mbd_experiments.csv_table import CsvRow, read_csv, write_csv
from mbd_experiments.user_study.study_facts import Pairs

FILE_NAME = "answers.csv"
COLUMNS = ("session", "source", "looks", "right", "placed_onto")


@dataclass(frozen=True)
class AnswerSheet:
    """What is right in one session, by perceived ids.

    Attributes:
        right: acceptable target ids by source id, of the sources that were answered.
        script: the (picked, placed onto) source ids that were asked for, in the order of the sheet.
    """

    right: Mapping[str, frozenset[str]]
    script: Pairs

    def check(self, session: RecordedSession) -> None:
        """Raises BagError when the sheet names other objects than the session has, or states too little."""
        task, target = session.tasks[-1].value, session.target_scenes[-1].value
        named = {"source": set(self.right) | {i for pair in self.script for i in pair}, "target": set()}
        named["target"] = {t for targets in self.right.values() for t in targets}
        for role, known in (("source", task.source.ids), ("target", target.ids)):
            if unknown := sorted(named[role] - set(known)):
                raise BagError(
                    f"{FILE_NAME} names {role} object '{unknown[0]}' in session '{session.name}', which has "
                    f"{', '.join(known)}"
                )
        if missing := [s for s in task.used_objects if not self.right.get(s)]:
            raise BagError(
                f"{FILE_NAME} does not state what is right for '{missing[0]}', which the demonstration of session "
                f"'{session.name}' uses"
            )


def read_answers(folder: Path) -> dict[str, AnswerSheet]:
    """The filled-in sheet of a folder by session; {} when there is none.

    Raises:
        BagError: it lacks a column, or answers one object twice.
    """
    path = folder / FILE_NAME
    if not path.exists():
        return {}
    rows = read_csv(path)
    if rows and (lacking := [c for c in COLUMNS if c not in rows[0] and c != "looks"]):
        raise BagError(
            f"{path}:1: column '{lacking[0]}' is missing; expected columns {', '.join(COLUMNS)}, separated by commas"
        )
    right: dict[str, dict[str, frozenset[str]]] = {}
    script: dict[str, list[tuple[str, str]]] = {}
    for number, row in enumerate(rows, start=2):
        session, source, targets, onto = (
            (row.get(c) or "").strip() for c in ("session", "source", "right", "placed_onto")
        )
        if not any(value for value in row.values()):
            continue  # a spreadsheet leaves empty rows behind
        if not session or not source:
            raise BagError(f"{path}:{number}: no session or no source; every row answers one object of one session")
        if source in right.setdefault(session, {}):
            raise BagError(f"{path}:{number}: '{source}' of session '{session}' is answered twice; remove a row")
        right[session][source] = frozenset(targets.replace(";", " ").split())
        if onto:
            script.setdefault(session, []).append((source, onto))
    return {name: AnswerSheet(by_source, tuple(script.get(name, ()))) for name, by_source in right.items()}


def blank_rows(session: RecordedSession) -> list[CsvRow]:
    """The rows to fill in for a session.

    Raises:
        BagError: it did not come to the assists.
    """
    if not session.tasks or not session.target_scenes:
        raise BagError(f"session '{session.name}' holds no task or no target scene: it ended before the assists")
    source = session.tasks[-1].value.source
    return [
        {
            "session": session.name,
            "source": o.object_id,
            "looks": f"{o.object_class or 'object'}, {'grey' if o.hue is None else f'hue {o.hue:.0f}'}",
            "right": "",
            "placed_onto": "",
        }
        for o in source.objects
    ]


def write_sheet(folder: Path, sessions: Iterable[RecordedSession]) -> Path:
    """Write the sheet of these sessions; what was filled in before stays. Returns its path."""
    path = folder / FILE_NAME
    rows: list[CsvRow] = [{c: r.get(c) or "" for c in COLUMNS} for r in read_csv(path)] if path.exists() else []
    known = {row["session"] for row in rows}
    for session in sessions:
        if session.name not in known:
            rows += blank_rows(session)
    return write_csv(path, rows)


def _tool() -> int:
    # Messages are needed to read bags only.
    from mbd_bag.ros.session_conversions import session_from_bag
    from mbd_bag.storage.bag import Bag

    parser = CommandParser(prog="answers", description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the study's bags")
    arguments = parser.parse_args()
    console = Console()
    sessions = []
    for path in bags_below([arguments.folder]):
        try:
            session = session_from_bag(Bag(path))
            blank_rows(session)
        except MbdError as error:
            console.print(f"[yellow]left out:[/] {escape(f'{path}: {error}')}", highlight=False, soft_wrap=True)
            continue
        sessions.append(session)
    path = write_sheet(arguments.folder, sessions)
    console.print(f"{escape(str(path))}: fill in the columns right and placed_onto", highlight=False, soft_wrap=True)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when there is no bag."""
    run_tool("answers", _tool)
