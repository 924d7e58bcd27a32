"""What the mapping infers from task, target scene and assists: the complete result (paper sec. 4.3, eq. 3-7)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Feature(StrEnum):
    """The seven comparison features in the order of the paper's Table 1."""

    HUE = "hue"
    HUE_SHIFT = "hue_shift"
    SIZE = "size"
    SIZE_SHIFT = "size_shift"
    SPATIAL = "spatial"
    AFFORDANCE = "affordance"
    PROPERTY = "property"


@dataclass(frozen=True)
class Mapping:
    """An injective mapping of source objects to target objects.

    Attributes:
        pairs: (source id, target id) in source-scene order; objects left out are unmapped.
        score: what the strategy gives it: V/(n |f|) for "mbd" (eq. 4), posterior probability for "evidence".
    """

    pairs: tuple[tuple[str, str], ...]
    score: float = 0.0

    @property
    def as_dict(self) -> dict[str, str]:
        """Source id -> target id."""
        return dict(self.pairs)


@dataclass(frozen=True)
class MappingEstimate:
    """Everything one inference states.

    Attributes:
        strategy: name of the strategy that made it.
        mapping: the predicted mapping m0.
        confidence: eq. 7 for "mbd", a calibrated probability for "evidence"; 0..1.
        winning: the feature set that gave it, alpha.
        runner_up: the best feature set that would map otherwise, beta; () when none.
        alternatives: other mappings with their scores, best first (ties included), capped.
        ties: how many mappings share the best score; 1 when unique.
        num_assists: how many assists it was computed from.
        warnings: assists it could not use or that contradict each other, one sentence each.
        next_question: source id of the step whose answer would teach most; "" when nothing is left to ask.
        information_gain: expected gain of that question [bit].
    """

    strategy: str
    mapping: Mapping
    confidence: float
    winning: tuple[Feature, ...] = ()
    runner_up: tuple[Feature, ...] = ()
    alternatives: tuple[Mapping, ...] = ()
    ties: int = 1
    num_assists: int = 0
    warnings: tuple[str, ...] = ()
    next_question: str = ""
    information_gain: float = 0.0


@dataclass(frozen=True)
class EstimateInputs:
    """Which inputs an estimate came from, and what the node compared it with.

    Attributes:
        task_stamp, scene_stamp, assists_stamp: stamps of its inputs [ns]; 0: none yet.
        threshold: the robot goes on alone from this confidence on.
        confident: whether it was reached.
    """

    task_stamp: int
    scene_stamp: int
    assists_stamp: int
    threshold: float
    confident: bool
