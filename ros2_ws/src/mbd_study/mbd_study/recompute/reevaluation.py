"""Compute a session's estimates once more from their recorded inputs, and compare.

The mapping node's output is a pure function of its latched inputs (task, target scene, assists). Here the same function
is called on what the bag holds of them: any difference means that the bag, the code or the parameters changed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TypeVar

from mbd_bag.errors import BagError
from mbd_bag.session.recorded_session import Recorded, RecordedSession
from mbd_bag.session.session_facts import recorded_parameters
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.parameters import MAPPING, mapping_config
from mbd_model.assists import Assist
from mbd_model.estimate import NO_MAPPING, EstimateInputs, Mapping, MappingEstimate
from mbd_model.objects import Scene
from mbd_model.task import Task

# Both sides compute in double precision; the order of sums may differ between versions of numpy.
TOLERANCE = 1e-9
ACTED_ON = ("num_assists", "strategy", "mapping", "confidence", "winning")

Value = TypeVar("Value")


@dataclass(frozen=True)
class Difference:
    """One field in which the recomputed estimate differs: its name, what was recorded, what was computed."""

    field: str
    recorded: str
    computed: str


@dataclass(frozen=True)
class EstimateCheck:
    """One recorded estimate, computed again.

    Attributes:
        recorded: as published, with its log time.
        computed: from the inputs it names; None when the bag lacks one of them.
        differences: () when they agree.
    """

    recorded: Recorded[MappingEstimate]
    computed: MappingEstimate | None
    differences: tuple[Difference, ...]

    @property
    def agrees(self) -> bool:
        """True when nothing differs."""
        return not self.differences


def recorded_config(session: RecordedSession, estimate: MappingEstimate, threshold: float) -> MappingConfig:
    """The parameters an estimate was made with: the mapping node's recorded ones, and what the estimate states itself.

    Raises:
        BagError: a recorded parameter is none that the mapping takes.
    """
    recorded = recorded_parameters(session.facts, MAPPING)
    return mapping_config(recorded | {"strategy": estimate.strategy, "threshold": threshold})


def input_of(recorded: Sequence[Recorded[Value]], stamp: int, log_time: int) -> Value | None:
    """The input with this stamp: the latest recorded before ``log_time``, else the first after; None: not in the bag.

    Topics have no order among each other, so an estimate may be recorded just before the input it came from.
    """
    named = [r for r in recorded if r.stamp == stamp]
    before = [r for r in named if r.log_time <= log_time]
    if before:
        return before[-1].value
    return named[0].value if named else None


def reevaluate(session: RecordedSession, tolerance: float = TOLERANCE) -> tuple[EstimateCheck, ...]:
    """Every recorded estimate against the one its inputs give now, in the order recorded.

    Args:
        session: as recorded, or with inputs computed again.
        tolerance: of scores and confidences. More than TOLERANCE (inputs measured again differ a little): then what the
            robot acts on is compared, that is mapping, winning features and confidence.

    Raises:
        BagError: the session has no estimate.
        MbdError: the recorded parameters or strategy are not of this version.
    """
    if not session.estimates:
        reached = session.states[-1].value.phase.name if session.states else "no phase at all"
        raise BagError(
            f"session '{session.name}' holds no mapping estimate, so there is nothing to compare; it reached {reached}"
        )
    return tuple(_compare(session, recorded, inputs, tolerance) for recorded, inputs in session.estimates)


def _compare(
    session: RecordedSession, recorded: Recorded[MappingEstimate], inputs: EstimateInputs, tolerance: float
) -> EstimateCheck:
    when = recorded.log_time
    task: Task | None = input_of(session.tasks, inputs.task_stamp, when)
    scene: Scene | None = input_of(session.target_scenes, inputs.scene_stamp, when)
    assists: tuple[Assist, ...] | None = input_of(session.assists, inputs.assists_stamp, when)
    if assists is None and inputs.assists_stamp == 0 and recorded.value.num_assists == 0:
        assists = ()
    denials = input_of(session.denials, inputs.assists_stamp, when) or ()
    if task is None or scene is None or assists is None:
        named = {"task": task, "target scene": scene, "assists": assists}
        missing = " and ".join(name for name, value in named.items() if value is None)
        return EstimateCheck(recorded, None, (Difference("inputs", f"from {missing}", "not in the bag"),))
    computed = infer(task, scene, assists, recorded_config(session, recorded.value, inputs.threshold), denials)
    return EstimateCheck(recorded, computed, differences(recorded.value, computed, tolerance))


# What the messages of older bags do not hold: without a best guess in the recording there is nothing to compare.
READINGS = ("best_guess", "obeying", "doubted", "doubt", "question_kind", "question_targets", "threshold")


def differences(
    recorded: MappingEstimate, computed: MappingEstimate, tolerance: float = TOLERANCE
) -> tuple[Difference, ...]:
    """The fields in which two estimates differ, numbers by more than the tolerance; see `reevaluate`."""
    found = []
    for entry in fields(MappingEstimate):
        if tolerance > TOLERANCE and entry.name not in ACTED_ON:
            continue
        if entry.name in READINGS and recorded.best_guess == NO_MAPPING:
            continue
        old, new = getattr(recorded, entry.name), getattr(computed, entry.name)
        if not _same(old, new, tolerance):
            found.append(Difference(entry.name, _text(old), _text(new)))
    return tuple(found)


def _same(old: object, new: object, tolerance: float) -> bool:
    if isinstance(old, float) and isinstance(new, float):
        return math.isclose(old, new, rel_tol=0.0, abs_tol=tolerance)
    if isinstance(old, tuple) and isinstance(new, tuple):
        return len(old) == len(new) and all(_same(a, b, tolerance) for a, b in zip(old, new, strict=True))
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        return old.pairs == new.pairs and _same(old.score, new.score, tolerance)
    return old == new


def _text(value: object) -> str:
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, tuple):
        return "; ".join(_text(v) for v in value) or "none"
    if isinstance(value, Assist):
        return f"{value.source_id}→{value.target_id}"
    if isinstance(value, Mapping):
        return " ".join(f"{source}→{target}" for source, target in value.pairs) or "none"
    return str(value)
