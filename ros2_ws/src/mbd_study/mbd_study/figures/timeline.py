"""A session's course as one SVG: the whole to scale in one line, and below it every event, row by row, kept apart.

A phase that lasts seconds of twenty minutes has room for its name, a long wait is cut and says how long it was, and
events stand in the bag's order.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from mbd_study.figures.time_axis import TimeAxis
from mbd_study.tables.events import EventRow

WIDTH = 960
_LEFT, _RIGHT, _ROW, _HEAD = 90, 24, 176, 58
_BAND, _ROBOT, _OPERATOR, _OTHER, _TOP, _BOTTOM = 0, 40, 62, 84, 104, 144
_ACCEPTED, _REFUSED, _WORD, _PROMPT = "#4c78a8", "#e45756", "#9aa5b1", "#59636e"
_NOTE, _MARKER, _FORM, _SPEECH, _STOP = "#b279a2", "#d67195", "#2a9d8f", "#bab0ac", "#b3261e"
_CONFIDENT, _NOT_SURE = "#54a24b", "#f58518"
_COLORS = ("#9ecae9", "#ffbf79", "#d6a5c9", "#88d27a", "#f2cf5b", "#83bcb6", "#cfc6c1", "#ff9d98")
_OTHERS = {"note": _NOTE, "marker": _MARKER, "form": _FORM, "speech": _SPEECH, "stop": _STOP, "service": _WORD}
_WORDS = {
    "prompt": "the robot",
    "word": "the operator enters",
    "note": "note",
    "marker": "marker",
    "form": "form",
    "speech": "the simulated teacher says",
    "stop": "stop",
    "service": "service",
}


def timeline_legend(rows: Sequence[EventRow]) -> str:
    """What the colours are, in HTML."""
    kinds = {row.kind for row in rows}
    refused = [(_REFUSED, "refused")] if any(r.accepted is False for r in rows) else []
    others = [(color, kind) for kind, color in _OTHERS.items() if kind in kinds]
    groups = (
        ("phases:", [(color, name) for name, color in _phase_colors(rows).items()]),
        ("events:", [(_PROMPT, "robot"), (_WORD, "word"), (_ACCEPTED, "accepted"), *refused, *others]),
        ("estimates:", [(_CONFIDENT, "confident"), (_NOT_SURE, "not sure")]),
    )
    lines = []
    for title, entries in groups:
        marks = "".join(f'<i style="background: {color}"></i>{escape(words)}' for color, words in entries)
        lines.append(f"{title}{marks}")
    return f'<p class="legend">{"<br>".join(lines)}</p>'


def timeline_svg(rows: Sequence[EventRow], duration: float) -> str:
    """The SVG element; every mark states in a tooltip what it is.

    Args:
        rows: of the session, in order.
        duration: of its bag [s].
    """
    # Only a skewed reply goes back in time; on the axis it stands beside its word.
    times = [0.0]
    for row in rows:
        times.append(max(times[-1], row.time_s))
    times.append(max(times[-1], duration))
    phases = _phases(rows, len(times) - 1)
    names = [(first, 7.0 * len(name) + 14) for name, first, _ in phases]
    axis = TimeAxis(times, names, WIDTH - _LEFT - _RIGHT)
    height = _HEAD + _ROW * axis.rows
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="timeline" xmlns="http://www.w3.org/2000/svg">',
        *_overview(phases, times, _phase_colors(rows)),
        *(part for row in range(axis.rows) for part in _frame(row)),
        *_bands(phases, axis, _phase_colors(rows)),
        *_cuts(axis),
        *_times(axis),
        *(mark for number, row in enumerate(rows, start=1) for mark in _marks(row, number, axis)),
        "</svg>",
    ]
    return "\n".join(parts)


def _phases(rows: Sequence[EventRow], last: int) -> list[tuple[str, int, int]]:
    """(name, number of its first moment, of its last) of each phase, in order."""
    begins = [(row.name, number) for number, row in enumerate(rows, start=1) if row.kind == "phase"]
    ends = [*(number for _, number in begins[1:]), last][: len(begins)]
    return [(name, first, end) for (name, first), end in zip(begins, ends, strict=True)]


def _phase_colors(rows: Sequence[EventRow]) -> dict[str, str]:
    names = dict.fromkeys(row.name.replace("_", " ") for row in rows if row.kind == "phase")
    return {name: _COLORS[k % len(_COLORS)] for k, name in enumerate(names)}


def clock_text(seconds: float) -> str:
    """A time as minutes and seconds: 19:30; below a minute 7.5 s.

    Args:
        seconds: from the beginning.
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


def _text(x: float, y: float, words: str, kind: str = "", anchor: str = "") -> str:
    more = (f' class="{kind}"' if kind else "") + (f' text-anchor="{anchor}"' if anchor else "")
    return f'<text x="{x:.1f}" y="{y:.1f}"{more}>{escape(words)}</text>'


def _overview(phases: Sequence[tuple[str, int, int]], times: Sequence[float], colors: dict[str, str]) -> Iterator[str]:
    """The whole session in one line, to scale."""
    whole = max(times[-1], 1e-9)
    scale = (WIDTH - _LEFT - _RIGHT) / whole
    yield _text(_LEFT - 8, 17, "to scale", "label", "end")
    for name, first, last in phases:
        x, width = _LEFT + times[first] * scale, max(0.5, (times[last] - times[first]) * scale)
        words = f"{name.replace('_', ' ')}: {clock_text(times[first])} to {clock_text(times[last])}"
        color = colors[name.replace("_", " ")]
        yield (
            f'<path d="M{x:.1f} 8h{width:.1f}v12h-{width:.1f}z" fill="{color}"><title>{escape(words)}</title></path>'
        )
    step = next((s for s in (5, 10, 30, 60, 120, 300, 600, 1800, 3600) if whole / s <= 10), 7200)
    for number in range(int(whole // step) + 1):
        yield _text(_LEFT + number * step * scale, 36, clock_text(number * step), "label", "middle")


def _frame(row: int) -> Iterator[str]:
    """What every row has: the names of its lines, and 0 and 1 of the confidence."""
    y = _HEAD + row * _ROW
    for words, down in (("phase", 15), ("robot", _ROBOT + 4), ("operator", _OPERATOR + 4), ("other", _OTHER + 4)):
        yield _text(_LEFT - 8, y + down, words, "label", "end")
    yield _text(_LEFT - 20, y + (_TOP + _BOTTOM) / 2 + 4, "confidence", "label", "end")
    for words, down in (("1", _TOP), ("0", _BOTTOM)):
        yield _text(_LEFT - 8, y + down + 4, words, "label", "end")
        yield f'<path d="M{_LEFT} {y + down}H{WIDTH - _RIGHT}" class="rule"/>'


def _bands(phases: Sequence[tuple[str, int, int]], axis: TimeAxis, colors: dict[str, str]) -> Iterator[str]:
    for name, first, last in phases:
        words = name.replace("_", " ")
        span = f"{words}: {clock_text(axis.times[first])} to {clock_text(axis.times[last])}"
        for number, (row, low, high) in enumerate(axis.stretches(first, last)):
            x, y = _LEFT + low, _HEAD + row * _ROW + _BAND
            yield (
                f'<rect x="{x:.1f}" y="{y}" width="{max(1.5, high - low):.1f}" height="22" fill="{colors[words]}">'
                f"<title>{escape(span)}</title></rect>"
            )
            if high - low > 7 * len(words):
                yield _text(x + 5, y + 15, words if number == 0 else f"… {words}")


def _cuts(axis: TimeAxis) -> Iterator[str]:
    """A wait that is drawn shorter than it was, with its length."""
    for cut in axis.cuts:
        number = axis.times.index(cut.end) - 1
        begin, end = axis.begin_of(number), axis.place_of(number + 1)
        x, y = _LEFT + (begin.x + end.x) / 2, _HEAD + end.row * _ROW
        yield f'<path d="M{x - 4:.1f} {y + 18}l4 -14m2 14l4 -14" class="cut"/>'
        yield _text(x, y + _OTHER + 4, f"⟵ {clock_text(cut.end - cut.start)} ⟶", "label", "middle")


def _times(axis: TimeAxis) -> Iterator[str]:
    """Times below each row, as many as have room."""
    last: tuple[int, float] | None = None
    for number, time in enumerate(axis.times):
        place = axis.begin_of(number)
        if last is None or place.row != last[0] or place.x - last[1] > 52:
            x, y = _LEFT + place.x, _HEAD + place.row * _ROW
            yield f'<path d="M{x:.1f} {y + _BOTTOM}v5" class="rule"/>'
            yield _text(x, y + _BOTTOM + 17, clock_text(time), "label", "middle")
            last = place.row, place.x


def _marks(row: EventRow, number: int, axis: TimeAxis) -> Iterator[str]:
    """The mark of an event; a phase has its band."""
    place = axis.place_of(number)
    x, y = _LEFT + place.x, _HEAD + place.row * _ROW
    if row.kind == "estimate":
        value = min(1.0, max(0.0, float(row.text)))
        words = f"confidence {row.text}, published as {row.name.replace('_', ' ')}"
        color = _CONFIDENT if row.name == "confident" else _NOT_SURE
        yield _circle(x, y + _BOTTOM - (_BOTTOM - _TOP) * value, color, row, words)
    elif row.kind == "reply":
        verdict = "accepted" if row.accepted else "refused"
        color = _ACCEPTED if row.accepted else _REFUSED
        yield _circle(x, y + _OPERATOR, color, row, f"{verdict}: {row.topic.rpartition('/')[2]}: {row.text}")
    elif row.kind == "word":
        words = " ".join(dict.fromkeys(w for w in (row.topic.rpartition("/")[2], row.name, row.target, row.text) if w))
        yield _circle(x, y + _OPERATOR, _WORD, row, f"{_WORDS['word']}: {words}")
    elif row.kind == "prompt":
        yield _circle(x, y + _ROBOT, _PROMPT, row, f"{_WORDS['prompt']}: {row.text}")
    elif row.kind in _OTHERS:
        words = " ".join(w for w in (row.name if row.kind != "note" else "", row.text) if w)
        yield _circle(x, y + _OTHER, _OTHERS[row.kind], row, f"{_WORDS[row.kind]}: {words}")


def _circle(x: float, y: float, color: str, row: EventRow, words: str) -> str:
    text = f"{clock_text(row.time_s)} {words}"
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{color}"><title>{escape(text)}</title></circle>'
