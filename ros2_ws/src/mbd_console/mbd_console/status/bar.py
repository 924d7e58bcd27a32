"""The operator's bar: connected, recorded, how old the picture is, how much room the disk has."""

from __future__ import annotations

from mbd_model.session import Phase

from mbd_console.palette import safe
from mbd_console.room.shown import ShownFilm, room_lamp
from mbd_console.state import ConsoleState
from mbd_console.status.recorder import SILENT
from mbd_console.words.texts import PageTexts

OLD_PICTURE = 2.0  # [s]
LITTLE_ROOM = 5e9  # [byte]


def status_bar(
    state: ConsoleState,
    texts: PageTexts,
    now: float,
    picture_at: float | None,
    films: tuple[ShownFilm, ...] = (),
    *,
    form: str = "",
    session_age: float | None = None,
) -> str:
    """HTML of the bar; each part is good, warns, or is bad, by its words and not by colour alone.

    Args:
        state: what is known.
        texts: in which language.
        now: [s, a steady clock].
        picture_at: when the last picture came [s, the same clock]; None before the first.
        films: of the room, that grow.
        form: title of the form that the participant fills in, "" for none.
        session_age: how old the last picture is by the session's clock [s], which stands while a simulation waits;
            None where it is not known.
    """
    parts = [_connected(state, texts), _recorded(state, texts, now)]
    if state.recording:
        parts.append(("bad live", texts("demonstration_recorded")))
    if form:
        parts.append(("warn", texts("form_shown_now", title=form)))
    if (lamp := room_lamp(films, texts, now)) is not None:
        parts.append(lamp)
    parts += [_picture(texts, now, picture_at, session_age), _disk(state, texts)]
    if state.recorder.missed:
        parts.append(("bad", texts("missed", count=state.recorder.missed)))
    return "".join(f'<span class="lamp {name}">{safe(words)}</span>' for name, words in parts)


def announced(
    state: ConsoleState, texts: PageTexts, now: float, films: tuple[ShownFilm, ...] = (), *, form: str = ""
) -> str:
    """What of it a screen reader says when it changes: not the ages, which always do."""
    parts = [_connected(state, texts)[1], "" if state.recorder.reported is None else _recorded(state, texts, now)[1]]
    lamp = room_lamp(films, texts, now)
    parts.append("" if lamp is None else lamp[1] if "live" in lamp[0] else texts("room_in_doubt"))
    parts.append(texts("form_shown_now", title=form) if form else "")
    return ", ".join([p for p in parts if p and "{" not in p] + [texts("demonstration_recorded")] * state.recording)


def _connected(state: ConsoleState, texts: PageTexts) -> tuple[str, str]:
    return ("good", texts("connected")) if state.session is not None else ("warn", texts("no_session"))


def _recorded(state: ConsoleState, texts: PageTexts, now: float) -> tuple[str, str]:
    reported = state.recorder.reported
    if reported is None:
        return "bad", texts("not_recorded")
    if now - reported > SILENT:
        return "bad", texts("recorder_silent", seconds=int(now - reported))
    if state.recorder.recording:
        return "good", texts("recorded")
    # What people say and fill in afterwards is recorded in the bag's next file: nothing to be warned of.
    over = state.phase in (Phase.DONE, Phase.ABORTED)
    return ("good", texts("recording_closed")) if over else ("warn", texts("recording_over"))


def _picture(texts: PageTexts, now: float, at: float | None, session_age: float | None) -> tuple[str, str]:
    if at is None:
        return "warn", texts("picture_none")
    age = now - at
    if age > OLD_PICTURE and session_age is not None and abs(session_age) <= OLD_PICTURE:
        return "warn", texts("picture_stands", seconds=int(age))
    return ("good", texts("picture_live")) if age <= OLD_PICTURE else ("bad", texts("picture_age", seconds=int(age)))


def _disk(state: ConsoleState, texts: PageTexts) -> tuple[str, str]:
    left = state.recorder.disk_left
    if left is None:
        return "warn", texts("disk_unknown")
    return "good" if left > LITTLE_ROOM else "bad", texts("disk_left", left=f"{left / 1e9:.1f}")
