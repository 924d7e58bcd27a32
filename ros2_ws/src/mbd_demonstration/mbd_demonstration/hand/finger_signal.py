"""A finger joint's recording as a clean signal: usable samples in order of time, wild ones out, its noise known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

# Faster than this a hand's fingers show nothing more, and a live look at ten minutes of 1 kHz would cost a core [Hz].
HIGHEST_RATE = 100.0
# Quantiles of |x| for x of a standard normal distribution, and the upper one of the distance of such a sample from the
# median of it and both beside; how much more the higher must say than the lower for motion.
LOWER_QUARTILE, MEDIAN = 0.3186, 0.6745
STICKS_OUT, MOTION = 0.9241, 3.0
# A driver that repeats values does so regularly, for at most so long [s], all the time.
HELD_RUNS, HELD_FOR, HELD_SHARE = 12, 0.5, 0.7
# From this spacing on [s] one sample may be all there is of a short rest: then no filter may take it out.
SPARSE = 0.3


@dataclass(frozen=True)
class FingerSignal:
    """A filtered finger joint.

    Attributes:
        stamps: (n,) strictly increasing [s].
        values: (n,) joint positions [its unit], without changes shorter than the debounce time.
        light: (n,) the same without single wild samples only: a short peak has its height there.
        noise: standard deviation of the filtered values' noise [its unit].
        quantum: smallest step the joint is read in [its unit]; 0 where too few samples tell it.
        spacing: median time between samples [s], 0 where there are fewer than two.
    """

    stamps: Floats
    values: Floats
    light: Floats
    noise: float
    quantum: float
    spacing: float

    @property
    def held_range(self) -> tuple[float, float]:
        """(lowest, highest) level held for three samples, so that wild ones beside each other do not count."""
        held = 1 if self.spacing > SPARSE else min(3, self.values.size)
        windows = np.lib.stride_tricks.sliding_window_view(self.values, held)
        return float(windows.max(axis=1).min()), float(windows.min(axis=1).max())

    @property
    def fastest(self) -> float:
        """By how much it goes within a second, or from one sample to the next, at most [its unit]."""
        apart = min(max(1, round(1.0 / self.spacing)), self.values.size - 1)
        return float(np.abs(self.values[apart:] - self.values[:-apart]).max())


def finger_signal(stamps: ArrayLike, joint: ArrayLike, debounce: float) -> FingerSignal:
    """Filter one finger joint's recording.

    Args:
        stamps: (n,) [s], in any order; repeated stamps and values that are not finite are left out.
        joint: (n,) positions in any unit.
        debounce: [s] changes shorter than this are glitches and are taken out by a running median.

    Raises:
        MbdError: the shapes differ.
    """
    t, g = np.asarray(stamps, dtype=float), np.asarray(joint, dtype=float)
    if t.shape != g.shape or t.ndim != 1:
        raise MbdError(f"stamps of shape {t.shape} for joint positions of shape {g.shape}; expected (n,) for both")
    usable = np.isfinite(t) & np.isfinite(g)
    t, first = np.unique(t[usable], return_index=True)
    g = g[usable][first]
    if t.size < 2:
        return FingerSignal(t, g, g, 0.0, 0.0, 0.0)
    t, g = _thinned(t, g)
    spacing = float(np.median(np.diff(t)))
    noise = _noise(g, spacing)
    # A median over 2 k + 1 samples takes out k wild ones beside each other and leaves every edge where it is.
    half = 0 if spacing > SPARSE else max(1, math.floor(debounce / spacing))
    values, light = (_running_median(g, k) for k in (half, min(half, 1)))
    noise *= 1.2533 / math.sqrt(2 * half + 1) if half else 1.0
    # Between few samples most steps are motion: they do not tell how finely the joint is read.
    quantum = 0.0 if spacing > SPARSE else _quantum(np.abs(np.diff(values)))
    return FingerSignal(t, values, light, noise, quantum, spacing)


def _running_median(g: Floats, half: int) -> Floats:
    """Median of each sample and ``half`` on each side of it."""
    if not half:
        return g
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(g, half, mode="edge"), 2 * half + 1)
    median: Floats = np.median(windows, axis=1)
    return median


def _thinned(t: Floats, g: Floats) -> tuple[Floats, Floats]:
    """(stamps, medians of blocks): at most HIGHEST_RATE; a block's stamp is its middle."""
    block = int(1.0 / (HIGHEST_RATE * float(np.median(np.diff(t)))))
    if block < 2:
        return t, g
    full = t.size // block * block
    return t[:full].reshape(-1, block).mean(axis=1), np.median(g[:full].reshape(-1, block), axis=1)


def _noise(g: Floats, spacing: float) -> float:
    """Standard deviation of a signal's noise [its unit], from all samples: what rests exactly has none.

    Where most of a sparse recording is motion only what sticks out of both samples beside it is counted: a motion,
    however few samples it has, does not. Else it is what no straight line through three samples explains. Of values
    that a driver repeats until it has new ones, one of each is taken.
    """
    if g.size < 3:
        return 0.0
    changes = np.flatnonzero(np.diff(g)) + 1
    runs = np.diff(changes)
    if runs.size > HELD_RUNS and 1.0 < (usual := float(np.median(runs))) <= HELD_FOR / spacing:
        regular = float((np.abs(runs - usual) <= 1.0).mean())
        if regular > HELD_SHARE and runs[runs <= usual + 1.0].sum() > HELD_SHARE * g.size:
            g = g[np.concatenate([[0], changes])]
    if g.size < 3:
        return 0.0
    out = np.abs(g[1:-1] - _running_median(g, 1)[1:-1])
    bends = g[:-2] - 2.0 * g[1:-1] + g[2:]
    quarter, half = np.quantile(np.abs(bends), [0.25, 0.5]) / (LOWER_QUARTILE, MEDIAN) / math.sqrt(6.0)
    # Of noise alone both say the same, and the median says it better; where most is motion it says too much.
    noise = float(half if half < MOTION * quarter else quarter)
    if spacing > SPARSE:
        return min(noise, float(np.quantile(out, 0.75)) / STICKS_OUT)
    # Noise below the step in which the joint is read shows in few samples only, each a step off.
    step = _quantum(np.abs(np.diff(g)))
    return max(noise, math.sqrt(float(np.mean(np.minimum(out, step) ** 2))))


def _quantum(steps: Floats) -> float:
    """Smallest step of a signal whose steps (n,) are these, wild ones aside; 0 where there is none."""
    return float(np.quantile(steps[steps > 0.0], 0.05)) if steps.any() else 0.0
