"""Where in a sound the test signal is: by correlation with the chirp that was played."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_model.room.chirp import HIGH, LOW, chirp
from numpy.typing import NDArray
from scipy.signal import butter, correlate, sosfiltfilt

# Share of a stretch of sound that is the chirp, as correlation in 0..1, from which it counts: noise comes to 0.1, and a
# chirp as loud as the noise around it to 0.7 (tests/mbd_study/test_room_sync.py).
LEAST = 0.3
_BAND = (0.8 * LOW, 1.1 * HIGH)  # [Hz] that are looked at: a room's rumble is below
_QUIET = 0.05  # of the loudest stretch: what is more quiet counts as that loud, since silence is like everything


@dataclass(frozen=True)
class FoundBeep:
    """A chirp found.

    Attributes:
        at: its begin [s] from the sound's first sample.
        likeness: correlation with what was played, in 0..1.
    """

    at: float
    likeness: float


def find_beep(samples: NDArray[np.float64], rate: float, *, rising: bool) -> FoundBeep | None:
    """The chirp in a sound, where it is most alike; None when there is none.

    Args:
        samples: shape (n,), of one channel.
        rate: samples a second [Hz].
        rising: the chirp that was mixed in; else the one that the speaker played.
    """
    played, turned = (chirp(rate, rising=rising, turned=turned) for turned in (False, True))
    if len(samples) < len(played):
        return None
    samples = np.asarray(sosfiltfilt(butter(4, _BAND, "bandpass", fs=rate, output="sos"), samples))
    # Whatever the phase, which a room turns: by the crest of a single wave it would jump by a whole one.
    alike = np.hypot(*(correlate(samples, wave, mode="valid", method="fft") for wave in (played, turned)))
    energy = np.cumsum(np.concatenate([[0.0], samples**2]))
    around = np.sqrt(np.maximum(energy[len(played) :] - energy[: -len(played)], 0.0))
    loudest = float(around.max())
    if loudest <= 0.0:
        return None
    likeness = alike / (np.maximum(around, _QUIET * loudest) * np.linalg.norm(played))
    best = int(np.argmax(likeness))
    return FoundBeep(best / rate, min(float(likeness[best]), 1.0)) if likeness[best] >= LEAST else None
