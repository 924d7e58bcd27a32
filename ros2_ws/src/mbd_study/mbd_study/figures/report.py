"""``report BAG --out FILE.html``: one session as one page with pictures and timeline, readable without a network."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import bag_parser, read_session, run_tool
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.session.session_facts import fingerprint
from mbd_bag.storage.bag import Bag
from mbd_model.errors import MbdError
from mbd_model.times import to_seconds
from rich.console import Console

from mbd_study.figures.pictures import draw_session
from mbd_study.figures.timeline import timeline_legend, timeline_svg
from mbd_study.recompute.reevaluation import reevaluate
from mbd_study.tables.events import EventRow, event_rows
from mbd_study.tables.session_table import AssistRow, assist_rows, readings_text

# Nothing is loaded from anywhere: the browser is instructed so.
_HEAD = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>{title}</title><style>
body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222 }}
h1 {{ font-size: 1.5rem }} h2 {{ font-size: 1.1rem; margin-top: 2rem }} img, svg {{ max-width: 100% }}
table {{ border-collapse: collapse; width: 100% }} td, th {{ text-align: left; padding: .3rem .6rem .3rem 0;
border-bottom: 1px solid #ddd; vertical-align: top }} .good {{ color: #2a7d2a }} .bad {{ color: #b3261e }}
svg text {{ font-size: 12px }} svg .label {{ fill: #666 }} svg .rule {{ stroke: #ccc }}
svg .cut {{ stroke: #222; fill: none }}
.legend {{ color: #666; font-size: 12px }} .legend i {{ display: inline-block; width: .8em; height: .8em;
margin: 0 .3em 0 1em }} th {{ white-space: nowrap }} details {{ margin-top: 1rem }}
</style></head><body>
"""


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table, without a heading when ``head`` is (); cells are HTML already."""
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>\n" for row in rows)
    heading = f"<tr>{''.join(f'<th>{escape(h)}</th>' for h in head)}</tr>\n" if head else ""
    return f"<table>{heading}{body}</table>"


def _picture(bag: Bag, session: RecordedSession) -> str:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "mapping.png"
        try:
            draw_session(bag, session, out)
        except MbdError as error:
            return f"<p>{escape(str(error))}</p>"
        data = base64.b64encode(out.read_bytes()).decode()
    return f'<img alt="source and target scene with the mapping between them" src="data:image/png;base64,{data}">'


def _assist(row: AssistRow) -> tuple[str, ...]:
    verdict = {True: '<span class="good">right</span>', False: '<span class="bad">wrong</span>', None: "unknown"}
    pairs = " ".join(
        f'<span class="{"bad" if s in row.wrong else ""}">{escape(s)}→{escape(t)}</span>' for s, t in row.pairs
    )
    for line in (*readings_text(row).splitlines(), row.doubted):
        pairs += f"<br>{escape(line)}" if line else ""
    confidence = f"{row.confidence:.4f}" + (" (confident)" if row.confident else "")
    asked = "<br>".join(escape(part) for part in (row.asked, row.answered) if part)
    return str(row.num_assists), asked, pairs, confidence, escape("+".join(row.winning)), verdict[row.correct]


def _event(row: EventRow) -> tuple[str, ...]:
    """One event, as the bag has it."""
    parts = [row.topic.rpartition("/")[2] if row.kind in ("word", "reply") else "", row.name, row.target, row.text]
    words = escape(
        " ".join(dict.fromkeys(part.replace("_", " ") if part == row.name else part for part in parts if part))
    )
    if row.accepted is False:
        words = f'<span class="bad">{words}</span>'
    late = "" if row.latency_s is None else f"{row.latency_s:.2f}"
    return f"{row.time_s:.2f}", row.kind, words, late


def _replayed(session: RecordedSession) -> str:
    try:
        comparisons = reevaluate(session)
    except MbdError as error:
        return escape(str(error))
    agreeing = sum(c.agrees for c in comparisons)
    mark = "good" if agreeing == len(comparisons) else "bad"
    return f'<span class="{mark}">{agreeing} of {len(comparisons)} estimates come out again</span>'


def report_html(bag: Bag, session: RecordedSession) -> str:
    """The page."""
    facts = session.facts
    general = [
        ("participant", facts.get("participant", "")),
        ("task", facts.get("task", "")),
        ("seed", facts.get("seed", "")),
        ("length", f"{to_seconds(bag.end - bag.start):.1f} s, {bag.message_count} messages"),
        ("set-up fingerprint", facts.get("fingerprint") or fingerprint(facts)),
        ("superseded by", facts.get("superseded_by", "")),
    ]
    parts = [_HEAD.format(title=escape(f"session {session.name}")), f"<h1>Session {escape(session.name)}</h1>"]
    parts += [f'<p class="bad">{escape(problem)}</p>' for problem in session.problems]
    rows = [(escape(name), escape(value)) for name, value in general if value]
    parts.append(_table((), [*rows, ("computed again offline", _replayed(session))]))
    parts += ["<h2>Mapping</h2>", _picture(bag, session)]
    events = event_rows(bag, session.name)
    duration = to_seconds(bag.end - bag.start)
    parts += ["<h2>Timeline</h2>", timeline_svg(events, duration), timeline_legend(events)]
    head = ("assists", "asked and answered", "mapping predicted", "confidence", "feature", "")
    parts += ["<h2>Assist by assist</h2>", _table(head, map(_assist, assist_rows(session)))]
    if session.tasks:
        steps = session.tasks[-1].value.steps
        cells = [(str(s.index + 1), s.kind.name.lower(), escape(s.primary_object), f"{s.distance:.3f}") for s in steps]
        parts += ["<h2>Demonstrated steps</h2>", _table(("step", "", "object", "distance [m]"), cells)]
    parts += ["<h2>Events</h2>", _table(("t [s]", "", "event", "after [s]"), map(_event, events))]
    listed = _table((), [(escape(k), escape(v)) for k, v in sorted(facts.items())])
    parts += [f"<details><summary>Parameters and versions ({len(facts)})</summary>{listed}</details>", "</body></html>"]
    return "\n".join(parts)


def _tool() -> int:
    parser = bag_parser(__doc__ or "")
    parser.add_argument("--out", type=Path, required=True, help="page to write (.html); not overwritten")
    arguments = parser.parse_args()
    console = Console()
    bag, session = read_session(arguments.bag, console)
    page = report_html(bag, session)
    try:
        with arguments.out.open("x", encoding="utf-8") as stream:
            stream.write(page)
    except OSError as error:
        raise BagError(f"{arguments.out} cannot be written ({error.strerror}); choose another --out") from error
    console.print(f"wrote {arguments.out}", highlight=False, soft_wrap=True)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the bag cannot be used."""
    run_tool("report", _tool)
