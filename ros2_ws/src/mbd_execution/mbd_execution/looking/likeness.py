"""How well an object seen fits one believed there: log-odds of being the same against being any other.

Each feature gives the logarithm of a ratio: how probable the measured difference is for the same object, over how
probable it is for two that have nothing to do with each other. The differences of the same object are mixtures: mostly
the sensor's noise, now and then more, rarely anything. So one feature that is off costs a limited amount, no feature
decides alone, and nothing is cut off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mbd_model.objects import SceneObject

from mbd_execution.boxes import sides, top
from mbd_execution.looking.expected import Expected


@dataclass(frozen=True)
class Mixture:
    """Differences of one feature of the same object: standard deviations, weights, and the range of unrelated ones.

    Attributes:
        noise: standard deviation of the sensor's noise.
        change: of what happens now and then: another side of it, another light.
        often: share of the second kind.
        rare: share of differences that are as of two unrelated objects.
        range: over which the difference of two unrelated objects is spread evenly.
    """

    noise: float
    change: float
    often: float
    rare: float
    range: float

    def log_ratio(self, difference: float) -> float:
        """Of that difference: above 0 it speaks for the same object."""
        usual = (1 - self.often - self.rare) * _normal(difference, self.noise)
        return math.log(self.range * (usual + self.often * _normal(difference, self.change)) + self.rare)


# Sides by the logarithm of their ratio, tops [m], hues [deg], saturations.
SIDE = Mixture(noise=0.06, change=0.25, often=0.08, rare=0.01, range=2.0)
TOP = Mixture(noise=0.006, change=0.03, often=0.08, rare=0.01, range=0.3)
HUE = Mixture(noise=3.0, change=12.0, often=0.04, rare=1e-4, range=360.0)
SATURATION = Mixture(noise=0.06, change=0.2, often=0.1, rare=0.01, range=1.0)
# Where it is: nobody touched it, somebody pushed it a little, put it where another one was, or anywhere on the table.
STAYED, PUSHED, SWAPPED, ANYWHERE = 0.82, 0.10, 0.05, 0.03  # shares
PUSH, SWAP, TABLE = 0.05, 0.02, 0.5  # [m], [m], [m^2]
FELL = math.log(0.02)  # of an object that lies now on what was its side
RAISED = math.log(0.1)  # of one that lay, and that somebody set upright where it lay
MIXED = -2.5  # the least of a feature of one that is seen together with what it stands on
NO_HUE = -2.0  # one of the two has a hue and the other has none


def log_odds(expected: Expected, seen: SceneObject) -> float:
    """Log-odds of a seen object to be the expected one, upright.

    Args:
        expected: as it should show.
        seen: as it was measured, ``centroid`` the middle of its box; its top is above the table.
    """
    raised = RAISED if expected.lying else 0.0
    return raised + place(expected, seen) + shape(expected, seen) + color(expected, seen)


def fallen_log_odds(expected: Expected, seen: SceneObject) -> float:
    """The same, had it fallen over: its height is one of its sides now."""
    was = expected.object
    longer, shorter = sorted((max(was.size[2], 1e-3), sides(was)[0]), reverse=True)
    now = sides(seen)
    lying = SIDE.log_ratio(math.log(now[0] / longer)) + SIDE.log_ratio(math.log(now[1] / shorter))
    lying += TOP.log_ratio(top(seen) - sides(was)[1])
    where = place(expected, seen) if expected.lying else FELL + _anywhere(expected, seen)
    return where + lying + color(expected, seen)


def place(expected: Expected, seen: SceneObject) -> float:
    """Of where it is."""
    apart = math.dist(expected.object.centroid[:2], seen.centroid[:2])
    near = STAYED * _normal2(apart, expected.spread) + PUSHED * _normal2(apart, PUSH)
    for other in expected.others:
        near += SWAPPED / len(expected.others) * _normal2(math.dist(other, seen.centroid[:2]), SWAP)
    return math.log(TABLE * near + ANYWHERE)


def shape(expected: Expected, seen: SceneObject) -> float:
    """Of its sides and its top; what a covered one does not show speaks against nothing."""
    was, now = sides(expected.object), sides(seen)
    by_top = TOP.log_ratio(top(seen) - top(expected.object))
    by_sides = sum(SIDE.log_ratio(math.log(b / a)) for a, b in zip(was, now, strict=True))
    return max(by_top, _least(expected)) + max(by_sides, _least(expected))


def color(expected: Expected, seen: SceneObject) -> float:
    """Of its hue and saturation; what a covered one does not show speaks against nothing."""
    by_color = _color(expected.object, seen)
    return max(by_color, _least(expected))


def _least(expected: Expected) -> float:
    """How much one feature may speak against an object at most [nats]."""
    return 0.0 if expected.covered else MIXED if expected.supported else -math.inf


def _color(was: SceneObject, seen: SceneObject) -> float:
    by_saturation = SATURATION.log_ratio(seen.saturation - was.saturation)
    if was.hue is None or seen.hue is None:
        return by_saturation + (0.0 if was.hue is seen.hue else NO_HUE)
    return by_saturation + HUE.log_ratio((was.hue - seen.hue + 180.0) % 360.0 - 180.0)


def _anywhere(expected: Expected, seen: SceneObject) -> float:
    apart = math.dist(expected.object.centroid[:2], seen.centroid[:2])
    return math.log(TABLE * (STAYED + PUSHED) * _normal2(apart, 2 * PUSH) + ANYWHERE)


def _normal(difference: float, deviation: float) -> float:
    return math.exp(-0.5 * (difference / deviation) ** 2) / (deviation * math.sqrt(2 * math.pi))


def _normal2(apart: float, deviation: float) -> float:
    return math.exp(-0.5 * (apart / deviation) ** 2) / (2 * math.pi * deviation**2)
