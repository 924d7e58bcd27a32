"""The sound of a film around some moments, decoded by PyAV; each sample where the file's own times put it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mbd_model.room.recording import RoomError
from numpy.typing import NDArray

RATE = 48_000  # [Hz] to which every sound is brought
_LEAD = 0.2  # [s] decoded before a stretch, until the decoder has settled
_NONE = np.zeros(0, np.float32)


@dataclass(frozen=True)
class SoundStretch:
    """A stretch of sound.

    Attributes:
        begin: of its first sample [s, from the film's time 0].
        samples: shape (n,), of one channel, in -1..1, ``RATE`` a second.
    """

    begin: float
    samples: NDArray[np.float64]


@dataclass(frozen=True)
class FilmSound:
    """What was read of a film.

    Attributes:
        stretches: one for each moment asked about.
        seconds: how long the film is, by its last packet [s].
        pictures: packets of pictures in it.
    """

    stretches: tuple[SoundStretch, ...]
    seconds: float
    pictures: int


def film_sound(path: Path, moments: Sequence[float], reach: float) -> FilmSound:
    """The sound of a film around some moments; also of one that breaks off.

    Args:
        path: of a file that FFmpeg reads.
        moments: [s, from the film's time 0].
        reach: [s] before and after each.

    Raises:
        RoomError: PyAV is not there, the file cannot be read, or it has no sound.
    """
    try:
        import av
    except ImportError as error:
        raise RoomError("PyAV, which reads films, is missing: pip install av (requirements/recordings.txt)") from error
    long = round(2 * reach * RATE)
    begins = [moment - reach for moment in moments]
    samples = [np.zeros(long) for _ in moments]
    last, pictures = 0.0, 0
    try:
        with av.open(str(path)) as film:
            if not film.streams.audio:
                raise RoomError(f"{path} has no sound, so no test signal can be in it; record the room with sound")
            sound = film.streams.audio[0]
            resampler = av.AudioResampler(format="flt", layout="mono", rate=RATE)
            for packet in film.demux():
                if packet.pts is None or packet.time_base is None:
                    continue
                at = float(packet.pts * packet.time_base)
                last = max(last, at)
                if packet.stream.type == "video":
                    pictures += 1
                if packet.stream is not sound or not any(b - _LEAD <= at <= b + 2 * reach for b in begins):
                    continue
                for frame in packet.decode():
                    if isinstance(frame, av.AudioFrame) and frame.pts is not None and frame.time_base is not None:
                        first = float(frame.pts * frame.time_base)
                        frame.pts = None  # the resampler would fill gaps; here each sample has the time of its frame
                        data = np.concatenate([part.to_ndarray()[0] for part in resampler.resample(frame)] or [_NONE])
                        for begin, kept in zip(begins, samples, strict=True):
                            _put(kept, round((first - begin) * RATE), data.astype(np.float64))
    except (av.FFmpegError, OSError) as error:
        raise RoomError(f"{path} cannot be read as a film: {error}") from error
    found = tuple(SoundStretch(begin, kept) for begin, kept in zip(begins, samples, strict=True))
    return FilmSound(found, last, pictures)


def _put(kept: NDArray[np.float64], place: int, data: NDArray[np.float64]) -> None:
    """Write samples from a place on, as far as they lie within."""
    first, end = max(place, 0), min(place + len(data), len(kept))
    if first < end:
        kept[first:end] = data[first - place : end - place]
