"""The mapping node's parameters, and the config they make. What the core has a default for takes it from there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mbd_model.parameters import ParameterSpec, ParameterTable, Value

from mbd_mapping.config import OWN_THRESHOLD, FeatureSpace, MappingConfig, MissingHue
from mbd_mapping.inference import STRATEGIES

_CORE = MappingConfig()


def _own_threshold(values: Mapping[str, Any]) -> Value:
    return MappingConfig(strategy=values["strategy"]).stop_at


MAPPING = ParameterTable(
    "mapping",
    (
        ParameterSpec("strategy", _CORE.strategy, "How mappings are inferred.", choices=tuple(sorted(STRATEGIES))),
        ParameterSpec(
            "feature_space", _CORE.feature_space.value, "Which feature sets compete.", choices=tuple(FeatureSpace)
        ),
        ParameterSpec(
            "missing_hue", _CORE.missing_hue.value, "What a missing hue counts as.", choices=tuple(MissingHue)
        ),
        ParameterSpec("sigma", _CORE.sigma, "Standard deviation of D relative to the range (eq. 2); above 0."),
        ParameterSpec("hue_tolerance", _CORE.hue_tolerance, "Hues this close do not vary.", "deg", range=(0.0, 180.0)),
        ParameterSpec(
            "size_tolerance", _CORE.size_tolerance, "Volumes within 1 + this do not vary.", range=(0.0, math.inf)
        ),
        ParameterSpec(
            "assist_error", _CORE.assist_error, "evidence: P(an assist is wrong); above 0, below 0.5.", range=(0.0, 0.5)
        ),
        ParameterSpec(
            "swap_error", _CORE.swap_error, "evidence: P(two assists are exchanged); below 0.5.", range=(0.0, 0.5)
        ),
        ParameterSpec(
            "similarity_noise",
            _CORE.similarity_noise,
            "evidence: similarities within this are the same to a teacher; below 1.",
            range=(0.0, 1),
        ),
        ParameterSpec(
            "threshold",
            OWN_THRESHOLD[_CORE.strategy],
            "The robot goes on alone from this confidence on; not given, the strategy's own: evidence 0.7, mbd 0.02.",
            range=(0.0, 1.0),
            read_only=False,
            derived=_own_threshold,
        ),
        ParameterSpec(
            "promise",
            0.0,
            "evidence: share of sessions in which going on alone is to be right, in place of the threshold; 0: none.",
            range=(0.0, 1.0),
        ),
        ParameterSpec(
            "doubt_at",
            _CORE.doubt_at,
            "evidence: an assist this probably wrong is asked about first.",
            range=(0.0, 1.0),
        ),
        ParameterSpec(
            "feature_prior",
            _CORE.priors.features,
            "evidence: how likely hue, hue shift, size, size shift, spatial, affordance and property are to matter, "
            "each relative to the others; above 0. `lab_prior` learns it from earlier sessions.",
        ),
        ParameterSpec("open_cost", _CORE.open_cost, "evidence: what an open question costs a person.", "s"),
        ParameterSpec("yes_no_cost", _CORE.yes_no_cost, "evidence: what one to be answered yes or no costs.", "s"),
        ParameterSpec("which_of_two_cost", _CORE.which_of_two_cost, "evidence: what one of two objects costs.", "s"),
    ),
)


def mapping_config(values: Mapping[str, Any]) -> MappingConfig:
    """How mappings are inferred.

    Args:
        values: of parameters of MAPPING by name. For those that are not among them the core's own default counts: a bag
            that does not hold one is of a version, or of a simulated study, that had nothing else.

    Raises:
        ConfigError: a value out of its range.
        PriorError: ``feature_prior`` is not seven positive numbers.
    """
    kinds: Mapping[str, type[FeatureSpace | MissingHue]] = {"feature_space": FeatureSpace, "missing_hue": MissingHue}
    named: dict[str, Any] = {name: kinds[name](value) if name in kinds else value for name, value in values.items()}
    if not named.get("promise", 1.0):
        del named["promise"]
    if "feature_prior" in named:
        named["priors"] = replace(_CORE.priors, features=tuple(named.pop("feature_prior")))
    return MappingConfig(**named)
