"""One bag, computed again from a stage and compared: what `reevaluate` does with each of many."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mbd_bag.session.command_line import open_session
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from mbd_model.errors import MbdError
from mbd_model.times import to_seconds

from mbd_study.recompute.given_parameters import with_facts
from mbd_study.recompute.redemonstration import with_computed_tasks
from mbd_study.recompute.reevaluation import TOLERANCE, EstimateCheck, reevaluate
from mbd_study.recompute.reperception import with_computed_scenes
from mbd_study.recompute.stages import RecomputeFrom, StageCheck

# How much a confidence may change when hues come from JPEG instead of the camera.
CLOUD_TOLERANCE = 0.02


@dataclass(frozen=True)
class SessionCheck:
    """A session computed again.

    Attributes:
        checks: scenes and tasks computed on the way; () from assists.
        comparisons: of every estimate.
    """

    checks: tuple[StageCheck, ...]
    comparisons: tuple[EstimateCheck, ...]

    @property
    def agrees(self) -> bool:
        """True when nothing computed differs from what was published."""
        return all(c.agrees for c in self.comparisons) and not any(c.differences for c in self.checks)


def check_session(bag: Bag, session: RecordedSession, stage: RecomputeFrom) -> SessionCheck:
    """Compute a session again from a stage.

    Raises:
        MbdError: the bag lacks what the stage needs, or its parameters are not of this version.
    """
    checks: list[StageCheck] = []
    if stage is RecomputeFrom.CLOUDS:
        session, scenes = with_computed_scenes(bag, session)
        checks += scenes
    if stage in (RecomputeFrom.CLOUDS, RecomputeFrom.SCENES):
        session, tasks = with_computed_tasks(bag, session)
        checks += tasks
    tolerance = CLOUD_TOLERANCE if stage is RecomputeFrom.CLOUDS else TOLERANCE
    return SessionCheck(tuple(checks), reevaluate(session, tolerance))


@dataclass(frozen=True)
class CheckSummary:
    """What is kept of one bag when there are many: a few numbers and sentences, whatever the bag's size.

    Attributes:
        path: of the bag.
        estimates, agreeing: how many were recorded, and how many of these come out again.
        lines: every difference, a sentence each; and what could not be computed.
        agrees: see `SessionCheck`; False when the bag cannot be used.
        failure: why the bag cannot be used; "" when it can.
        recorded_seconds, seconds: the session's length, and how long computing took [s].
    """

    path: Path
    estimates: int = 0
    agreeing: int = 0
    lines: tuple[str, ...] = ()
    agrees: bool = False
    failure: str = ""
    recorded_seconds: float = 0.0
    seconds: float = 0.0


def check_bag(path: Path, stage: RecomputeFrom, given: Mapping[str, str] | None = None) -> CheckSummary:
    """Compute one bag again; a bag that cannot be used is a summary that states why.

    Args:
        path: of the bag.
        stage: to compute from.
        given: facts in place of those the bag states, see `given_parameters`.
    """
    begun = time.perf_counter()
    try:
        bag, session = open_session(path)
        checked = check_session(bag, with_facts(session, given or {}), stage)
    except MbdError as error:
        return CheckSummary(path, failure=str(error), seconds=time.perf_counter() - begun)
    return CheckSummary(
        path=path,
        estimates=len(checked.comparisons),
        agreeing=sum(c.agrees for c in checked.comparisons),
        lines=tuple(difference_lines(checked, bag.start)),
        agrees=checked.agrees,
        recorded_seconds=to_seconds(bag.end - bag.start),
        seconds=time.perf_counter() - begun,
    )


def difference_lines(checked: SessionCheck, start: int) -> list[str]:
    """Every difference as a sentence.

    Args:
        checked: a session computed again.
        start: log time that counts as 0 [ns].
    """
    entries = [(c.log_time, f"{c.what} ", c.differences, c.skipped) for c in checked.checks]
    entries += [(c.recorded.log_time, "", c.differences, "") for c in checked.comparisons]
    lines = []
    for log_time, what, differences, skipped in entries:
        when = f"t {to_seconds(log_time - start):.1f} s, "
        if skipped:
            lines.append(f"{when}{what}not computed: {skipped}")
        lines += [f"{when}{what}{d.field}: recorded {d.recorded}, recomputed {d.computed}" for d in differences]
    return lines
