"""What the mapping infers from task, target scene and assists: the complete result (paper sec. 4.3, eq. 3-7)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mbd_model.assists import Assist


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


class QuestionKind(StrEnum):
    """What the robot would ask next."""

    WHAT_NEXT = "what_next"  # open: "What do I use now?", "Where do I go next?"
    IS_THIS_IT = "is_this_it"  # yes or no: "Is this the one for that?"
    WHICH_OF_TWO = "which_of_two"  # one of two, or neither
    IS_THAT_SO = "is_that_so"  # about an assist that is doubted: "You gave me t3 for s1: is that so?"


NO_MAPPING = Mapping(())


@dataclass(frozen=True)
class MappingEstimate:
    """Everything one inference states.

    Attributes:
        strategy: name of the strategy that made it.
        mapping: the mapping to carry out: the obeying one, unless an assist is doubted; then the best guess.
        confidence: eq. 7 for "mbd", for "evidence" the probability that ``mapping`` is right; 0..1.
        winning: the feature set that gave it, alpha.
        runner_up: the best feature set that would map otherwise, beta; () when none.
        alternatives: other mappings with their scores, best first (ties included), capped.
        ties: how many mappings share the best score; 1 when unique.
        num_assists: how many assists it was computed from.
        warnings: assists it could not use or that contradict each other, one sentence each.
        next_question: source id of the step whose answer would teach most; "" when nothing is left to ask.
        information_gain: expected gain of that question [bit].
        best_guess: the most probable mapping when any unconfirmed assist may be wrong, with its probability.
        obeying: the most probable mapping that holds every assist in force (of contradicting ones the later; for "mbd"
            the earlier, as in the paper), with its probability.
        doubted: the unconfirmed assist to ask about before going on alone; None when none is doubted.
        doubt: probability that ``doubted`` is wrong given everything else; 0 when None.
        question_kind: how to ask ``next_question``; IS_THAT_SO when an assist is doubted.
        question_targets: the target ids the question names: none, one, or two.
        threshold: the confidence from which ``confident`` holds: fixed, or what keeps the promise here.
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
    best_guess: Mapping = NO_MAPPING
    obeying: Mapping = NO_MAPPING
    doubted: Assist | None = None
    doubt: float = 0.0
    question_kind: QuestionKind = QuestionKind.WHAT_NEXT
    question_targets: tuple[str, ...] = ()
    threshold: float = 0.0

    @property
    def executed(self) -> Mapping:
        """The mapping to carry out: the obeying one; what an older version, which named none, predicted."""
        return self.obeying if self.obeying.pairs else self.mapping

    @property
    def confident(self) -> bool:
        """Whether the robot may go on alone: sure enough, no assist left to ask about, and no other mapping as good."""
        return self.doubted is None and self.ties <= 1 and self.confidence >= self.threshold


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
