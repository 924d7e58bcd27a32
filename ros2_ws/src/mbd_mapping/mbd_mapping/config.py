"""Every constant of the mapping, validated once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from mbd_model.errors import MbdError
from mbd_model.estimate import QuestionKind

from mbd_mapping.teachers.priors import FITTED, Priors

# "mbd": the best one of the paper's experiment 3. "evidence": up to it each assist buys as many right
# answers on the CHOOSE half, beyond it half as many (docs/mapping.md).
OWN_THRESHOLD = {"mbd": 0.02, "evidence": 0.7}


class ConfigError(MbdError):
    """A parameter of the mapping is out of its range."""


class FeatureSpace(StrEnum):
    """Which feature sets compete: F of Algorithm 1."""

    SINGLE = "single"  # the 7 features one by one: experiments 2 and 3, and the interactive robot
    ALL = "all"  # all 127 non-empty subsets: experiment 1


class MissingHue(StrEnum):
    """What an object too grey to have a hue counts as."""

    GREY = "grey"  # the centre of the colour circle: like grey, a quarter turn from every hue
    AS_RECORDED = "as_recorded"  # the number -1000 deg, as the study's program took it


@dataclass(frozen=True)
class MappingConfig:
    """Parameters of one inference.

    Attributes:
        strategy: name of the strategy, a key of ``inference.STRATEGIES``.
        threshold: the robot goes on alone from this confidence on; None takes the strategy's own (OWN_THRESHOLD).
        sigma: standard deviation of D relative to a feature's range r (eq. 2); 0.34 gives the paper's numbers.
        feature_space: which feature sets compete.
        missing_hue: what a missing hue counts as.
        hue_tolerance: source hues closer than this do not vary [deg] (pruning of F).
        size_tolerance: source volumes whose ratio is within 1 + this do not vary (pruning of F).
        tie_tolerance: mappings this close to the best value V/(n|f|) are tied with it.
        max_ties: tied mappings listed and counted at most; a count that reaches it is a lower bound.
        max_alternatives: alternatives on the estimate at most.
        assist_error: "evidence": probability that an assist names a wrong target.
        swap_error: "evidence": probability that two of all assists of a session are given for each other.
        priors: "evidence": what is believed of teachers beforehand.
        similarity_noise: "evidence": within what two similarities are the same to a teacher; what objects say of how
            exactly they were measured comes on top. 0 takes teachers as exact.
        promise: "evidence": share of sessions in which going on alone must be right; it takes the place of
            ``threshold``. None: the threshold decides.
        doubt_at: "evidence": an assist this probably wrong is asked about before the robot goes on alone.
        question_kinds: "evidence": which kinds of question compete for the next one; "mbd" asks open ones only.
        open_cost, yes_no_cost, which_of_two_cost: what a question of each kind costs a person [s].
    """

    strategy: str = "evidence"
    threshold: float | None = None
    sigma: float = 0.34
    feature_space: FeatureSpace = FeatureSpace.SINGLE
    missing_hue: MissingHue = MissingHue.GREY
    hue_tolerance: float = 0.0
    size_tolerance: float = 0.0
    tie_tolerance: float = 1e-9
    max_ties: int = 100
    max_alternatives: int = 10
    assist_error: float = 0.04
    swap_error: float = 0.25
    priors: Priors = FITTED
    similarity_noise: float = 0.02
    promise: float | None = None
    doubt_at: float = 0.4
    question_kinds: tuple[QuestionKind, ...] = (
        QuestionKind.WHAT_NEXT,
        QuestionKind.IS_THIS_IT,
        QuestionKind.WHICH_OF_TWO,
    )
    open_cost: float = 8.0
    yes_no_cost: float = 4.0
    which_of_two_cost: float = 5.0

    def __post_init__(self) -> None:
        """Validate once; raises ConfigError naming the parameter, its value and its range."""
        self._require(math.isfinite(self.sigma) and self.sigma > 0, "sigma", "a positive number")
        self._require(self.threshold is None or 0.0 <= self.threshold <= 1.0, "threshold", "in [0, 1]")
        self._require(0.0 <= self.hue_tolerance <= 180.0, "hue_tolerance", "in [0, 180] deg")
        self._require(math.isfinite(self.size_tolerance) and self.size_tolerance >= 0, "size_tolerance", "0 or more")
        self._require(0.0 <= self.tie_tolerance < 0.1, "tie_tolerance", "in [0, 0.1)")
        self._require(0.0 < self.assist_error < 0.5, "assist_error", "in (0, 0.5)")
        self._require(0.0 <= self.swap_error < 0.5, "swap_error", "in [0, 0.5)")
        self._require(0.0 <= self.similarity_noise < 1.0, "similarity_noise", "in [0, 1)")
        self._require(self.promise is None or 0.0 < self.promise < 1.0, "promise", "in (0, 1)")
        self._require(
            self.promise is None or self.strategy == "evidence",
            "promise",
            "None for strategy 'mbd', whose confidence is no probability; set strategy 'evidence' to promise something",
        )
        self._require(0.0 < self.doubt_at <= 1.0, "doubt_at", "in (0, 1]")
        self._require(
            bool(self.question_kinds) and QuestionKind.IS_THAT_SO not in self.question_kinds,
            "question_kinds",
            "one or more of what_next, is_this_it, which_of_two; is_that_so is asked whenever an assist is doubted",
        )
        for name in ("open_cost", "yes_no_cost", "which_of_two_cost"):
            cost = getattr(self, name)
            self._require(math.isfinite(cost) and cost > 0.0, name, "a positive number of seconds")
        self._require(self.max_ties >= 1, "max_ties", "1 or more")
        self._require(self.max_alternatives >= 0, "max_alternatives", "0 or more")

    @property
    def stop_at(self) -> float:
        """The confidence from which the robot goes on alone."""
        return OWN_THRESHOLD.get(self.strategy, 0.5) if self.threshold is None else self.threshold

    def _require(self, holds: bool, name: str, expected: str) -> None:
        if not holds:
            raise ConfigError(f"mapping parameter '{name}' is {getattr(self, name)}; it must be {expected}")
