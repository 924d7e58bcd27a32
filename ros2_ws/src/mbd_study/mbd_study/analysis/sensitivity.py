"""What so many participants can show: the least difference found with 80 % probability, and the least p there is.

References:
    Cohen, J. (1988): Statistical Power Analysis for the Behavioral Sciences, 2nd ed. Routledge.
    Faul, F. et al. (2007): G*Power 3. Behavior Research Methods 39, 175-191.
"""

from __future__ import annotations

from math import comb, sqrt

import numpy as np
from scipy import optimize, special

LEVEL = 0.05
POWER = 0.8
_LARGEST = 100.0
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(160)
# Of a rank test beside the t test, where values are normal (its asymptotic relative efficiency).
RANKS = 3.0 / 3.141592653589793


def t_power(effect: float, one: int, other: int | None, level: float = LEVEL) -> float:
    """The probability that a two-sided t test finds a difference.

    Args:
        effect: true difference, by the standard deviation of the differences where paired (d_z), else by that within
            the groups (d).
        one: number of participants, of the first group.
        other: of the second; None: the same participants, in pairs.
        level: of significance.
    """
    degrees = one - 1 if other is None else one + other - 2
    if degrees < 1:
        return 0.0
    shift = abs(effect) * (sqrt(one) if other is None else sqrt(one * other / (one + other)))
    critical = float(special.stdtrit(degrees, 1 - level / 2))
    # Over the spread that the sample happens to have; scipy's noncentral t has no value far out.
    low, high = np.sqrt(2 * special.gammaincinv(degrees / 2, (1e-12, 1 - 1e-12)))
    spread = low + (high - low) * (_NODES + 1) / 2
    density = (
        (degrees - 1) * np.log(spread) - spread**2 / 2 - (degrees / 2 - 1) * np.log(2) - special.gammaln(degrees / 2)
    )
    bound = critical * spread / sqrt(degrees)
    found = special.ndtr(shift - bound) + special.ndtr(-bound - shift)
    return float(min(1.0, (_WEIGHTS * np.exp(density) * found).sum() * (high - low) / 2))


def least_effect(one: int, other: int | None, level: float = LEVEL, power: float = POWER) -> float | None:
    """The least standardized difference that is found with a probability; None: with so few, none of any size.

    Args:
        one: number of participants, of the first group.
        other: of the second; None: in pairs.
        level: of significance.
        power: that probability.
    """
    high = 0.1
    while t_power(high, one, other, level) < power:
        high *= 2
        if high > _LARGEST:
            return None
    return float(optimize.brentq(lambda d: t_power(float(d), one, other, level) - power, 1e-6, high))


def needed(effect: float, *, paired: bool, level: float = LEVEL, power: float = POWER) -> int:
    """How many participants (in each group, where not paired) find a standardized difference with a probability.

    Args:
        effect: more than 0.
        paired: the same participants in both conditions.
        level: of significance.
        power: that probability.
    """
    low, high = 2, 4
    while t_power(effect, high, None if paired else high, level) < power:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        if t_power(effect, middle, None if paired else middle, level) < power:
            low = middle
        else:
            high = middle
    return high


def least_p(one: int, other: int | None) -> float:
    """The least two-sided p that an exact rank or count test can have: what no result could fall below.

    Args:
        one: number of participants, of the first group.
        other: of the second; None: in pairs.
    """
    return 2.0 / 2**one if other is None else min(1.0, 2.0 / comb(one + other, one))
