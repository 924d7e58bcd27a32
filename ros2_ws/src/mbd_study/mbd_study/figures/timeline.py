"""A session's course as one SVG: phases, wizard events, assists, and the confidence after each estimate."""

from __future__ import annotations

from html import escape

from mbd_bag.replay.replay_plan import phase_times
from mbd_bag.session.recorded_session import RecordedSession
from mbd_model.session import Phase
from mbd_model.times import to_seconds

WIDTH, HEIGHT = 960, 250
_LEFT, _RIGHT = 90, 20
_PHASES_Y, _EVENTS_Y, _TOP, _BOTTOM = 30, 86, 118, 210
_ACCEPTED, _REFUSED, _NOTE, _CONFIDENT, _NOT_SURE = "#4c78a8", "#e45756", "#b279a2", "#54a24b", "#f58518"
_COLORS = ("#9ecae9", "#ffbf79", "#d6a5c9", "#88d27a", "#f2cf5b", "#83bcb6", "#bab0ac", "#ff9d98")


def timeline_legend(session: RecordedSession) -> str:
    """What the colours are, in HTML: short phases have no room for their names in the picture."""
    phases = dict.fromkeys(phase for phase, _ in phase_times(session))
    named = [(_color(phase), phase.name.replace("_", " ").lower()) for phase in phases]
    events = [(_ACCEPTED, "accepted"), (_REFUSED, "refused"), (_NOTE, "note")]
    estimates = [(_CONFIDENT, "confident"), (_NOT_SURE, "not sure")]
    groups = (("phases:", named), ("wizard events:", events), ("estimates:", estimates))
    lines = []
    for title, entries in groups:
        marks = "".join(f'<i style="background: {color}"></i>{escape(words)}' for color, words in entries)
        lines.append(f"{title}{marks}")
    return f'<p class="legend">{"<br>".join(lines)}</p>'


def _color(phase: Phase) -> str:
    return _COLORS[(phase.value - 1) % len(_COLORS)]


class _Axis:
    """Log time [ns] to x [px]."""

    def __init__(self, start: int, end: int) -> None:
        self._start = start
        self._scale = (WIDTH - _LEFT - _RIGHT) / max(1, end - start)

    def __call__(self, log_time: int) -> float:
        return _LEFT + (log_time - self._start) * self._scale

    def seconds(self, log_time: int) -> str:
        return f"{to_seconds(log_time - self._start):.1f} s"


def timeline_svg(session: RecordedSession, start: int, end: int) -> str:
    """The SVG element; every mark states in a tooltip what it is.

    Args:
        session: as recorded.
        start: log time of its bag's first message [ns].
        end: of its last [ns].
    """
    at = _Axis(start, end)
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="timeline" xmlns="http://www.w3.org/2000/svg">',
        *_phases(session, at, end),
        _label("events", _EVENTS_Y + 4),
        *_events(session, at),
        *_confidence(session, at),
        *_ticks(start, end, at),
        "</svg>",
    ]
    return "\n".join(parts)


def _label(text: str, y: float) -> str:
    return f'<text x="{_LEFT - 8}" y="{y}" text-anchor="end" class="label">{escape(text)}</text>'


def _mark(x: float, y: float, color: str, words: str) -> str:
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{color}"><title>{escape(words)}</title></circle>'


def _phases(session: RecordedSession, at: _Axis, end: int) -> list[str]:
    times = phase_times(session)
    parts = [_label("phase", _PHASES_Y + 20)]
    for number, (phase, begin) in enumerate(times):
        until = times[number + 1][1] if number + 1 < len(times) else end
        x, width = at(begin), max(1.5, at(until) - at(begin))
        name = phase.name.replace("_", " ").lower()
        words = f"{name}: {at.seconds(begin)} to {at.seconds(until)}"
        color = _color(phase)
        parts.append(
            f'<rect x="{x:.1f}" y="{_PHASES_Y}" width="{width:.1f}" height="32" fill="{color}">'
            f"<title>{escape(words)}</title></rect>"
        )
        if width > 7 * len(name):
            parts.append(f'<text x="{x + 5:.1f}" y="{_PHASES_Y + 20}">{escape(name)}</text>')
    return parts


def _events(session: RecordedSession, at: _Axis) -> list[str]:
    parts = []
    for reply in session.replies:
        color = _ACCEPTED if reply.value.accepted else _REFUSED
        words = f"{at.seconds(reply.log_time)} {reply.value.topic}: {reply.value.reason}"
        parts.append(_mark(at(reply.log_time), _EVENTS_Y, color, words))
    parts += [
        _mark(at(n.log_time), _EVENTS_Y, _NOTE, f"{at.seconds(n.log_time)} note: {n.value}") for n in session.notes
    ]
    return parts


def _confidence(session: RecordedSession, at: _Axis) -> list[str]:
    height = _BOTTOM - _TOP
    parts = [_label("confidence", _TOP + height / 2 + 4), _label("1", _TOP + 4), _label("0", _BOTTOM + 4)]
    parts += [f'<line x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{y}" y2="{y}" class="rule"/>' for y in (_TOP, _BOTTOM)]
    for recorded, inputs in session.estimates:
        estimate = recorded.value
        words = (
            f"{at.seconds(recorded.log_time)}: {estimate.num_assists} assists, confidence {estimate.confidence:.4f} "
            f"({'confident' if inputs.confident else 'not sure'}, threshold {inputs.threshold:g}), "
            + " ".join(f"{s}>{t}" for s, t in estimate.mapping.pairs)
        )
        color = _CONFIDENT if inputs.confident else _NOT_SURE
        parts.append(_mark(at(recorded.log_time), _BOTTOM - height * min(1.0, estimate.confidence), color, words))
    return parts


def _ticks(start: int, end: int, at: _Axis) -> list[str]:
    length = max(1e-9, to_seconds(end - start))
    step = next((s for s in (1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800) if length / s <= 12), 3600)
    parts = []
    for number in range(int(length // step) + 1):
        x = at(start + number * step * 1_000_000_000)
        parts.append(
            f'<text x="{x:.1f}" y="{_BOTTOM + 28}" text-anchor="middle" class="label">{number * step} s</text>'
        )
    return parts
