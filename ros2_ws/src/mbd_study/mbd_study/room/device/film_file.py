"""A WebM film that grows: VP8 and Opus, written a second at a time, so that what there is of it plays."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from mbd_model.room.chirp import chirp
from numpy.typing import NDArray

from mbd_study.room.device.source import TakenFrame, require_av

RATE = 48_000  # [Hz] of its sound
_LOUDNESS = 0.25  # of a test signal
_APART = 0.02  # [s] by which sound may leave its time before silence is put in, or samples are left out
_MILLISECOND = Fraction(1, 1000)
_FASTEST = {"deadline": "realtime", "cpu-used": "8", "error-resilient": "1"}
_RATE_OF_BITS = 1_500_000  # [bit/s] of pictures


class FilmFile:
    """Writes a film.

    Args:
        path: of an empty file.
        started: when its time 0 is [s, steady clock].
        size: (width, height) of its pictures [px]; None: sound alone.
        sound: it has sound.
    """

    def __init__(self, path: Path, started: float, size: tuple[int, int] | None, *, sound: bool) -> None:
        self._av = require_av()
        self.started = started
        options = {"cluster_time_limit": "1000", "flush_packets": "1"}
        self._film: Any = self._av.open(str(path), "w", format="webm", options=options)
        self._eyes: Any = None
        self._voice: Any = None
        if size is not None:
            width, height = (side - side % 2 for side in size)
            self._eyes = self._film.add_stream("libvpx", rate=30, options=_FASTEST)
            self._eyes.width, self._eyes.height, self._eyes.pix_fmt = width, height, "yuv420p"
            self._eyes.bit_rate = _RATE_OF_BITS
            self._eyes.codec_context.time_base = _MILLISECOND
        if sound:
            self._voice = self._film.add_stream("libopus", rate=RATE, layout="mono")
            self._resampler = self._av.AudioResampler(format="flt", layout="mono", rate=RATE)
        self._last_picture, self._samples, self._signals = -1, 0, list[float]()

    def add_picture(self, taken: TakenFrame) -> None:
        """A picture; one that is not after the last is left out."""
        at = round(1000 * (taken.at - self.started))
        if at <= self._last_picture or at < 0:
            return
        frame = taken.frame.reformat(self._eyes.width, self._eyes.height, "yuv420p")
        frame.pts, frame.time_base, self._last_picture = at, _MILLISECOND, at
        # The device marks key frames of its own, as every picture of a camera is one.
        frame.pict_type = self._av.video.frame.PictureType.NONE
        self._film.mux(self._eyes.encode(frame))

    def signal(self, at: float) -> None:
        """Mix a test signal into the sound that is to come; ``at``: when it begins [s, steady clock]."""
        self._signals.append(at - self.started)

    def add_sound(self, taken: TakenFrame) -> None:
        """A piece of sound; where its device counts otherwise than the clock, silence fills what is missing."""
        frame = taken.frame
        frame.pts = None  # the resampler would fill gaps by itself
        parts = [part.to_ndarray()[0] for part in self._resampler.resample(frame)]
        data = np.concatenate(parts).astype(np.float32) if parts else np.zeros(0, np.float32)
        place = round((taken.at - self.started) * RATE)
        late = place - self._samples
        if late > _APART * RATE:
            data = np.concatenate([np.zeros(late, np.float32), data])
        elif late < -_APART * RATE:
            data = data[-late:]
        self._write(data)

    def _write(self, data: NDArray[np.float32]) -> None:
        first, last = self._samples, self._samples + len(data)
        data = data.copy()
        for at in self._signals:
            played = (_LOUDNESS * chirp(RATE, rising=True)).astype(np.float32)
            begin = round(at * RATE)
            lower, upper = max(begin, first), min(begin + len(played), last)
            if lower < upper:
                data[lower - first : upper - first] += played[lower - begin : upper - begin]
        self._signals = [at for at in self._signals if at * RATE + RATE > first]
        if len(data):
            frame = self._av.AudioFrame.from_ndarray(np.clip(data, -1.0, 1.0)[None], "flt", "mono")
            frame.rate, frame.pts, frame.time_base = RATE, first, Fraction(1, RATE)
            self._film.mux(self._voice.encode(frame))
        self._samples = last

    def close(self) -> None:
        """Write what the coders still hold, and end the file."""
        for stream in (self._eyes, self._voice):
            if stream is not None and (stream is self._voice or self._last_picture >= 0):
                self._film.mux(stream.encode(None))
        self._film.close()
