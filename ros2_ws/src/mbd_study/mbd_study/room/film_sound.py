"""The sound of a film around some moments, decoded by PyAV; each sample where the file's own times put it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mbd_model.room.recording import RoomError
from numpy.typing import NDArray

RATE = 48_000  # [Hz] to which every sound is brought
_SETTLING = 2.0  # [s] before and after a stretch whose stamps are looked at, too
_GAP = 0.15  # [s] by which a frame is late that does not follow on the one before
_NONE = np.zeros(0, np.float32)


@dataclass(frozen=True)
class SoundFrame:
    """What one packet decodes to: its stamp [s, from the film's time 0], and samples, shape (n,), ``RATE`` a second."""

    at: float
    samples: NDArray[np.float64]


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


def film_sound(path: Path, moments: Sequence[float], *, before: float, after: float) -> FilmSound:
    """The sound of a film around some moments; also of one that breaks off.

    Args:
        path: of a file that FFmpeg reads.
        moments: [s, from the film's time 0].
        before: [s] before each.
        after: [s] after each.

    Raises:
        RoomError: PyAV is not there, the file cannot be read, or it has no sound.
    """
    try:
        import av
    except ImportError as error:
        raise RoomError("PyAV, which reads films, is missing: pip install av (requirements/recordings.txt)") from error
    if path.exists() and not path.stat().st_size:
        raise RoomError(f"{path} is empty: its page was closed, or refused, before a second of it had come")
    begins = [moment - before for moment in moments]
    wanted = [(begin - _SETTLING, begin + before + after + _SETTLING) for begin in begins]
    frames: list[SoundFrame] = []
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
                if packet.stream is not sound or not any(first <= at <= end for first, end in wanted):
                    continue
                for frame in packet.decode():
                    if isinstance(frame, av.AudioFrame) and frame.pts is not None and frame.time_base is not None:
                        first = float(frame.pts * frame.time_base)
                        frame.pts = None  # the resampler would fill gaps; here each frame has a time of its own
                        data = np.concatenate([part.to_ndarray()[0] for part in resampler.resample(frame)] or [_NONE])
                        frames.append(SoundFrame(first, data.astype(np.float64)))
    except (av.FFmpegError, OSError) as error:
        raise RoomError(f"{path} cannot be read as a film: {error.strerror or error}") from error
    long = round((before + after) * RATE)
    return FilmSound(tuple(_stretch(frames, begin, long) for begin in begins), last, pictures)


def _stretch(frames: Sequence[SoundFrame], begin: float, long: int) -> SoundStretch:
    """The stretch of ``long`` samples from ``begin`` [s] on, silence where the film has none.

    A browser that is late to fetch a frame stamps it late, by tens of milliseconds under load, though its samples
    follow on those before: all frames that hang together are put where most of their stamps say.
    """
    kept = np.zeros(long)
    near = [f for f in frames if begin - _SETTLING - 0.1 <= f.at <= begin + long / RATE + _SETTLING + 0.1]
    run: list[SoundFrame] = []
    for frame in near:
        if run and abs(frame.at - run[-1].at - len(run[-1].samples) / RATE) > _GAP:
            _put(kept, run, begin)
            run = []
        run.append(frame)
    _put(kept, run, begin)
    return SoundStretch(begin, kept)


def _put(kept: NDArray[np.float64], run: Sequence[SoundFrame], begin: float) -> None:
    """Write frames that hang together, as far as they lie within."""
    if not run:
        return
    lengths = np.cumsum([0, *(len(frame.samples) for frame in run)])
    start = float(np.median([frame.at - length / RATE for frame, length in zip(run, lengths, strict=False)]))
    data, place = np.concatenate([frame.samples for frame in run]), round((start - begin) * RATE)
    first, end = max(place, 0), min(place + len(data), len(kept))
    if first < end:
        kept[first:end] = data[first - place : end - place]
