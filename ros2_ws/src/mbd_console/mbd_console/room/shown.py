"""What the pages show of the films of the room, by a browser or by devices of a machine."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mbd_model.room.device_report import DeviceReport

from mbd_console.words.texts import PageTexts

SILENT = 6.0  # [s] without a sign of a film after which it is in doubt; there is one a second
GIVEN_UP = 60.0  # [s] without a sign after which a film counts as broken off
_DEVICE_BROKE_OFF = "room_broke_off"


class FilmedBy(StrEnum):
    """What films."""

    BROWSER = "browser"
    DEVICE = "device"


@dataclass(frozen=True)
class ShownFilm:
    """A film that grows, or was meant to.

    Attributes:
        name: of its file, without ending.
        last: when something came last [s, a steady clock].
        refused: name of the sentence that says why nothing more is taken, "" while it is.
        by: what films.
        sound, picture: whether the film has them.
    """

    name: str
    last: float
    refused: str = ""
    by: FilmedBy = FilmedBy.BROWSER
    sound: bool = True
    picture: bool = True

    def broke_off(self, now: float) -> bool:
        """Whether nothing more comes; ``now`` [s, the clock of ``last``]."""
        return bool(self.refused) or now - self.last > GIVEN_UP


Films = tuple[ShownFilm, ...]


def room_lamp(films: Films, texts: PageTexts, now: float) -> tuple[str, str] | None:
    """The bar's lamp, as kind and words: of what goes wrong first; None where no room is recorded.

    Args:
        films: that grow, or were meant to.
        texts: in which language.
        now: [s, the clock of ``last``].
    """
    for film in films:
        if film.broke_off(now):
            return "bad", texts("room_broke_off", by=texts(f"room_by_{film.by}"))
    silent = [film for film in films if now - film.last > SILENT]
    if silent:
        worst = min(silent, key=lambda film: film.last)
        return "bad", texts("room_silent", seconds=int(now - worst.last), by=texts(f"room_by_{worst.by}"))
    if not films:
        return None
    by = " + ".join(texts(f"room_by_{kind}") for kind in FilmedBy if any(film.by is kind for film in films))
    return "bad live", texts("room_recorded", what=texts(_what(films)), by=by)


def room_sentence(films: Films, texts: PageTexts, now: float) -> tuple[str, bool]:
    """What the participant is told, "" where no room is recorded; and whether it is recorded now.

    A film from which nothing comes may be one all the same: it is said to be recorded until it counts as broken off.

    Args:
        films: that grow, or were meant to.
        texts: in which language.
        now: [s, the clock of ``last``].
    """
    growing = tuple(film for film in films if not film.broke_off(now))
    if growing:
        return texts(f"{_what(growing)}_participant"), True
    return (texts("room_over_participant") if films else ""), False


def on_device_report(films: Films, report: DeviceReport, now: float) -> Films:
    """The films by devices, after one of them reported.

    Args:
        films: before.
        report: of one.
        now: [s, a steady clock].
    """
    others = tuple(film for film in films if film.name != report.name)
    if report.ended and not report.lost:
        return others
    if not report.lost:
        others = tuple(film for film in others if not film.broke_off(now))  # it goes on, in another file
    refused = _DEVICE_BROKE_OFF if report.lost else ""
    film = ShownFilm(report.name, now, refused, FilmedBy.DEVICE, report.sound, report.picture)
    return (*others, film)


def _what(films: Films) -> str:
    """Name of the words for what is recorded."""
    sound, picture = any(film.sound for film in films), any(film.picture for film in films)
    return "room_both" if sound and picture else "room_only_sound" if sound else "room_only_picture"
