"""The test signal's sound: a chirp, whose start is found in a noisy room to less than a millisecond.

Two sound: a rising one is mixed into what is recorded, and half a second later a falling one comes from the speaker.
They are told apart by their direction; what the speaker, the air and the microphone add is how late the second is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LOW, HIGH = 1000.0, 4000.0  # [Hz]
SECONDS = 0.25
BY_AIR_AFTER = 0.5  # [s] from the begin of the one that is mixed in to that of the speaker's
EDGE = 0.01  # [s] over which it swells and fades, so that it does not click


def chirp(rate: float, *, rising: bool, turned: bool = False) -> NDArray[np.float64]:
    """Samples, shape (rate * 0.25,), in -1..1, the first at the signal's begin.

    Args:
        rate: samples a second [Hz]; more than 8 kHz.
        rising: from 1 to 4 kHz; else from 4 to 1 kHz.
        turned: by a quarter of a wave.
    """
    t = np.arange(round(SECONDS * rate)) / rate
    first, last = (LOW, HIGH) if rising else (HIGH, LOW)
    phase = 2.0 * np.pi * (first * t + (last - first) * t**2 / (2.0 * SECONDS))
    edge = np.clip(np.minimum(t, SECONDS - t) / EDGE, 0.0, 1.0)
    return np.asarray((np.cos if turned else np.sin)(phase) * edge)
