"""What the pages show of the films of the room."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_console.words.texts import PageTexts

SILENT = 6.0  # [s] without a chunk after which a film is in doubt; one comes a second


@dataclass(frozen=True)
class ShownFilm:
    """A film that grows, or was meant to.

    Attributes:
        name: of its file, without ending.
        last: when something came last [s, a steady clock].
        refused: name of the sentence that says why nothing more is taken, "" while it is.
    """

    name: str
    last: float
    refused: str = ""


def room_lamp(films: tuple[ShownFilm, ...], texts: PageTexts, now: float) -> tuple[str, str] | None:
    """The bar's lamp, as kind and words: of what goes wrong first; None where no room is recorded.

    Args:
        films: that grow.
        texts: in which language.
        now: [s, the clock of ``last``].
    """
    if any(film.refused for film in films):
        return "bad", texts("room_broke_off")
    silent = max((now - film.last for film in films), default=0.0)
    if silent > SILENT:
        return "bad", texts("room_silent", seconds=int(silent))
    return ("bad live", texts("room_recorded")) if films else None
