"""What is believed of teachers beforehand: the one table of constants of strategy "evidence".

The shares are those of greatest likelihood on the CHOOSE half of the teacher families, in which the paper's own
teachers, who go by one feature or by two, have half the weight: as ``./mbd run mbd_experiments fit_priors`` prints them
(docs/mapping.md). Set by hand are the list of groups, and that LARGER and REVERSED, which no family of that half tells
from PAIR and ORDER, have a third of their share.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from mbd_model.errors import MbdError

NUM_FEATURES = 7


class PriorError(MbdError):
    """A prior that is none."""


class Group(StrEnum):
    """What kind of teacher a hypothesis is about."""

    SINGLE = "single"  # goes by one feature
    PAIR = "pair"  # by two, equally
    LARGER = "larger"  # by three or more, equally; only in the feature space "all"
    WEIGHTED = "weighted"  # weighs all features that vary, some more, some less
    ORDER = "order"  # by rank: of size, left to right, near to far, row by row
    REVERSED = "reversed"  # by rank against rank: the largest to the smallest, mirrored
    OTHER = "other"  # by nothing we measure: every mapping is equally likely


class Level(StrEnum):
    """How exactly the teacher's mapping is the best of the hypothesis as we measure it."""

    EXACT = "exact"  # one of the best mappings
    MEASURED = "measured"  # best but for what measuring errors do to a similarity
    LOOSE = "loose"  # a teacher who does not choose so exactly


@dataclass(frozen=True)
class Priors:
    """Prior probabilities, each (group or level) share >= 0; they are divided by their sum over what can be.

    Attributes:
        groups: share of each Group.
        levels: share of each Level within every group but OTHER.
        features: (7,) how likely each feature is to matter, relative to the others: 1 unless learned in a lab.
        loose_noise: by how much the total similarity of what a LOOSE teacher chooses falls short, typically.
    """

    groups: tuple[tuple[Group, float], ...]
    levels: tuple[tuple[Level, float], ...]
    features: tuple[float, ...] = (1.0,) * NUM_FEATURES
    loose_noise: float = 0.1

    def __post_init__(self) -> None:
        """Validate once; raises PriorError naming what is wrong."""
        for name, table, kinds in (("groups", self.groups, Group), ("levels", self.levels, Level)):
            found = dict(table)
            if set(found) != set(kinds) or len(found) != len(table):
                raise PriorError(f"prior '{name}' names {sorted(found)}; it must name each of {sorted(kinds)} once")
            if not all(math.isfinite(v) and v >= 0.0 for v in found.values()):
                raise PriorError(f"prior '{name}' is {found}; every share must be 0 or more")
        if dict(self.groups)[Group.OTHER] <= 0.0 or not sum(v for _, v in self.levels):
            raise PriorError("prior of group 'other' or of all levels is 0; something else must always be possible")
        if len(self.features) != NUM_FEATURES or not all(math.isfinite(v) and v > 0.0 for v in self.features):
            raise PriorError(f"prior 'features' is {self.features}; expected {NUM_FEATURES} positive numbers")
        if not self.loose_noise > 0.0:
            raise PriorError(f"prior 'loose_noise' is {self.loose_noise}; it must be more than 0")

    def group(self, group: Group) -> float:
        """Its share."""
        return dict(self.groups)[group]

    def level(self, level: Level) -> float:
        """Its share."""
        return dict(self.levels)[level]


FITTED = Priors(
    groups=(
        (Group.SINGLE, 0.311),
        (Group.PAIR, 0.315),
        (Group.LARGER, 0.105),
        (Group.WEIGHTED, 0.05),
        (Group.ORDER, 0.072),
        (Group.REVERSED, 0.024),
        (Group.OTHER, 0.122),
    ),
    levels=((Level.EXACT, 0.762), (Level.MEASURED, 0.125), (Level.LOOSE, 0.112)),
)
