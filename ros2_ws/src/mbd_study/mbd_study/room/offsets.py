"""By how much a film of the room and its session's bag differ at each test signal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mbd_model.room.chirp import BY_AIR_AFTER, SECONDS
from mbd_model.room.recording import RoomRecording, RoomSignal

from mbd_study.room.beep import find_beep
from mbd_study.room.film_sound import RATE, FilmSound, film_sound

# [s] around where a signal ought to begin, in which it is looked for; less than lies between two of them.
REACH = 0.6
_EARLIER, _LATER = 0.1, 0.6  # [s] before and after its moment, in which the speaker's chirp is looked for


@dataclass(frozen=True)
class SignalOffset:
    """One test signal.

    Attributes:
        number: from 1.
        marked: its moment in the bag [s, session clock]; None where the bag has no such note.
        offset: what the film shows minus what the bag has [s], positive where the film is late; None without either.
        uncertainty: of the clocks' match [s].
        by_air: how late the speaker's chirp came by air [s], less what the browser states for the speaker; None where
            the microphone did not pick it up.
    """

    number: int
    marked: float | None
    offset: float | None
    uncertainty: float
    by_air: float | None

    @property
    def worst(self) -> float:
        """The largest difference there may be [s]; 0 where nothing was measured."""
        return 0.0 if self.offset is None else abs(self.offset) + self.uncertainty


@dataclass(frozen=True)
class FilmOffsets:
    """A film's test signals; ``seconds``: how long it is; ``pictures``: how many it has."""

    signals: tuple[SignalOffset, ...]
    seconds: float
    pictures: int

    @property
    def worst(self) -> float:
        """The largest difference [s]; infinite without a signal that was found in film and bag."""
        return max((s.worst for s in self.signals if s.offset is not None), default=float("inf"))


def film_offsets(film: Path, recording: RoomRecording, marked: Mapping[int, float]) -> FilmOffsets:
    """How a film stands to the bag.

    Args:
        film: its file.
        recording: what was written beside it.
        marked: number of a signal -> its moment in the bag [s, session clock].

    Raises:
        RoomError: the film cannot be read.
    """
    moments = [signal.browser - recording.started for signal in recording.signals]
    sound = film_sound(film, moments, before=REACH, after=REACH + BY_AIR_AFTER + _LATER + SECONDS)
    found = tuple(
        _offset(recording, signal, sound, place, marked.get(signal.number))
        for place, signal in enumerate(recording.signals)
    )
    return FilmOffsets(found, sound.seconds, sound.pictures)


def _offset(
    recording: RoomRecording, signal: RoomSignal, sound: FilmSound, place: int, marked: float | None
) -> SignalOffset:
    stretch = sound.stretches[place]
    uncertainty = recording.nearest(signal.browser).uncertainty
    mixed = find_beep(stretch.samples[: round((2 * REACH + SECONDS) * RATE)], RATE, rising=True)
    if mixed is None:
        return SignalOffset(signal.number, marked, None, uncertainty, None)
    shown = recording.session_time(recording.started + stretch.begin + mixed.at)
    first = round(mixed.at * RATE)
    begin, end = (first + round(s * RATE) for s in (BY_AIR_AFTER - _EARLIER, BY_AIR_AFTER + _LATER))
    after = find_beep(stretch.samples[begin:end], RATE, rising=False)
    by_air = None if after is None else after.at - _EARLIER - signal.latency
    return SignalOffset(signal.number, marked, None if marked is None else shown - marked, uncertainty, by_air)
