"""A rehearsed study on one page: was the plan kept, what came out, where everything lies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

_STYLE = """body{font:16px/1.5 sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#1b1f24;background:#fff}
table{border-collapse:collapse;margin:1rem 0}td,th{border:1px solid #bbb;padding:.25rem .6rem;text-align:left}
.warn{background:#fff3cd;padding:.6rem 1rem;border-left:.4rem solid #b8860b}img{max-width:100%;height:auto}
pre{overflow-x:auto;background:#f4f5f7;padding:.8rem}a{color:#0b57a4}"""


@dataclass(frozen=True)
class RehearsedRow:
    """A session as the page lists it; ``report`` is the file of its own page, None without one."""

    session: str
    participant: str
    condition: str
    task: str
    phase: str
    deviation: str
    report: Path | None


def rehearsal_page(
    title: str, facts: Sequence[tuple[str, str]], rows: Sequence[RehearsedRow], folder: Path, analysis: str
) -> str:
    """The page, as HTML that loads nothing from elsewhere.

    Args:
        title: of the study.
        facts: (name, value) of the summary.
        rows: a session each.
        folder: that the page lies in; links are relative to it, and what is in it is linked.
        analysis: text of the analysis, "" without one.
    """
    summary = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in facts)
    sessions = "".join(_row(row, folder) for row in rows)
    tables = "".join(f"<li>{_link(p, folder)}</li>" for p in sorted(folder.glob("*/*.csv")) + _more(folder))
    pictures = "".join(
        f'<figure><img src="{escape(p.relative_to(folder).as_posix())}" alt="{escape(p.stem)}">'
        f"<figcaption>{escape(p.relative_to(folder).as_posix())}</figcaption></figure>"
        for p in sorted(folder.glob("*/*.png"))
    )
    said = f"<h2>Analysis</h2><pre>{escape(analysis)}</pre>" if analysis else ""
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head><body><main>'
        f"<h1>{escape(title)}</h1>"
        '<p class="warn">A rehearsal: participants, operator, robot, table, and every answer to a form are simulated. '
        "Nothing here says anything about people.</p>"
        f"<table>{summary}</table>"
        "<h2>Sessions, in the order they were held</h2><table><tr><th>session</th><th>participant</th>"
        f"<th>condition</th><th>task</th><th>ended in</th><th>deviation</th></tr>{sessions}</table>"
        f"{said}<h2>Figures</h2>{pictures or '<p>None.</p>'}<h2>Tables</h2><ul>{tables}</ul></main></body></html>\n"
    )


def _row(row: RehearsedRow, folder: Path) -> str:
    name = _link(row.report, folder, row.session) if row.report is not None else escape(row.session)
    cells = (row.participant, row.condition, row.task, row.phase, row.deviation)
    return f"<tr><td>{name}</td>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"


def _more(folder: Path) -> list[Path]:
    return [path for path in (folder / "plan.yaml", folder / "tables" / "datapackage.json") if path.exists()]


def _link(path: Path, folder: Path, text: str = "") -> str:
    place = path.relative_to(folder).as_posix()
    return f'<a href="{escape(place)}">{escape(text or place)}</a>'
