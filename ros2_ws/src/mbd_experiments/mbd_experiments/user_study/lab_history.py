"""What a lab prior would have done: the sessions of each participant mapped with what those of the others teach."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from mbd_bag.errors import BagError
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.teachers.lab_prior import FEATURES, LabPrior
from mbd_model.estimate import MappingEstimate

from mbd_experiments.user_study.cases import Case

COUNTS = (0, 1, 2, 3, 4)  # assists after which the best guess is looked at, beside all of them
LEAST = 1e-3  # probability of right mappings that are not among those the estimate lists, at most about this
Ends = Mapping[str, MappingEstimate]


@dataclass(frozen=True)
class HistoryScore:
    """How the best guess fares over all sessions.

    Attributes:
        right: in how many sessions it is right after each of COUNTS, and after all assists.
        log_probability: mean, over the same, of the log of the probability given to right mappings.
        informs: mean probability, over the participants left out, that the others' tasks prefer some features.
    """

    right: tuple[int, ...]
    log_probability: float
    informs: float


def ends_of(cases: Sequence[Case], config: MappingConfig) -> dict[str, MappingEstimate]:
    """The estimate with all assists of each session, by its name: what a history is learned from."""
    return {c.name: infer(c.task, c.target, c.assists, config) for c in cases}


def shuffled(ends: Ends, rng: np.random.Generator) -> dict[str, MappingEstimate]:
    """The same history with features drawn at random in place of those that mattered: it says nothing."""
    return {
        name: replace(
            end, winning=tuple(FEATURES[int(k)] for k in rng.choice(len(FEATURES), len(end.winning), replace=False))
        )
        for name, end in ends.items()
    }


def left_out(cases: Sequence[Case], ends: Ends | None, config: MappingConfig) -> HistoryScore:
    """Every session with the prior that the sessions of the other participants teach; without one if ``ends`` is None.

    Raises:
        BagError: all sessions are of one participant.
    """
    participants = sorted({c.participant for c in cases})
    if ends is not None and len(participants) < 2:
        raise BagError(
            f"all {len(cases)} sessions are of participant '{participants[0]}'; leaving one out takes two or more"
        )
    right = np.zeros(len(COUNTS) + 1, dtype=int)
    logs, informs = [], []
    for participant in participants:
        prior = LabPrior()
        if ends is not None:
            prior = LabPrior.of((ends[c.name], c.assists) for c in cases if c.participant != participant)
        informs.append(prior.informs)
        own = config if ends is None else prior.applied_to(config)
        for case in (c for c in cases if c.participant == participant):
            for place, count in enumerate((*COUNTS, len(case.assists))):
                estimate = infer(case.task, case.target, case.assists[:count], own)
                right[place] += case.solved_by(estimate.best_guess.as_dict)
                listed = _listed(estimate)
                logs.append(math.log(max(LEAST, sum(p for m, p in listed.items() if case.solved_by(dict(m))))))
    return HistoryScore(tuple(right.tolist()), float(np.mean(logs)), float(np.mean(informs)))


def _listed(estimate: MappingEstimate) -> dict[tuple[tuple[str, str], ...], float]:
    """Every mapping the estimate names, with its probability."""
    return {m.pairs: m.score for m in (estimate.mapping, estimate.best_guess, *estimate.alternatives)}
