"""Within what a similarity means nothing, feature by feature: to people, and to what was measured."""

from __future__ import annotations

import numpy as np

from mbd_mapping.similarity import HUE, HUE_RANGE, HUE_SHIFT, NUM_FEATURES, SIZE, SIZE_SHIFT, Comparison, hue_difference
from mbd_mapping.tables import Floats


def layer_noise(comparison: Comparison) -> Floats:
    """(7,) standard deviation of a similarity of each feature.

    That is the configuration's ``similarity_noise``, for nobody tells two reds apart that a camera can; and, where both
    objects of a pair say how exactly they were measured, the errors of that on top, carried through eq. 2: the root
    mean square over all pairs.
    """
    source, target, config = comparison.source, comparison.target, comparison.config
    floor = config.similarity_noise
    noise = np.full(NUM_FEATURES, floor)
    if source.hue_std is not None and target.hue_std is not None:
        difference = np.nan_to_num(hue_difference(comparison.target_hue[None, :], comparison.source_hue[:, None]))
        slope = comparison.fixed[HUE] * np.abs(difference) / (config.sigma * HUE_RANGE) ** 2
        noise[[HUE, HUE_SHIFT]] = np.hypot(floor, _mean_error(slope, source.hue_std, target.hue_std))
    if source.volume_std is not None and target.volume_std is not None:
        ratio = target.volume[None, :] / source.volume[:, None]
        spread = float(source.volume.max() / source.volume.min())
        slope = comparison.fixed[SIZE] * np.abs(ratio - 1.0) / (config.sigma * spread) ** 2 * ratio
        noise[[SIZE, SIZE_SHIFT]] = np.hypot(floor, _mean_error(slope, source.volume_std, target.volume_std))
    return noise


def _mean_error(slope: Floats, source_std: Floats, target_std: Floats) -> float:
    """Root mean square over all pairs of slope (n, m) times the error of their difference; 0 where one is NaN."""
    error = source_std[:, None] ** 2 + target_std[None, :] ** 2
    return float(np.sqrt(np.where(np.isnan(error), 0.0, slope**2 * error).mean()))
