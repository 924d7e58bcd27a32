"""``promise``: calibrate stopping on the CHOOSE half, and show what it keeps on families and people kept apart.

Prints what belongs into mbd_mapping/stopping/promise_table.py, then, for each promise, the share of sessions
right and the assists asked for on the REPORT half (and on the real sessions, leaving one participant out), beside the
best fixed threshold of equal success.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.stopping.promise import PromiseCalibration, critical_of, logit
from mbd_mapping.tables import Floats
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one
from rich.console import Console

from mbd_experiments.public_study.study_folder import read_study
from mbd_experiments.teacher_families.families import FAMILIES, Half
from mbd_experiments.teacher_families.playing import finish, listen
from mbd_experiments.teacher_families.suite import lessons_of

KEPT_RANKS = 100
PROMISES = (0.8, 0.9, 0.95)


@dataclass(frozen=True)
class Session:
    """One session's states in order.

    Attributes:
        group: the family, or the participant.
        confidence, left, right: (k,) of each state; a state with a doubted assist has confidence 0: it is no stop.
            The last state is always one: nobody is left to ask.
    """

    group: str
    confidence: Floats
    left: Floats
    right: Floats


def simulated(half: Half, count: int, seed: int, config: MappingConfig) -> list[Session]:
    """``count`` sessions of each family of a half; the large scenes are left to the suite."""
    found = []
    for family in FAMILIES:
        if family.half != half or family.counts is not None:
            continue
        for lesson in lessons_of(family, seed, count):
            said = listen(lesson, config)
            # When all is told nothing is left but to ask about what is doubted: what comes of that counts at the end.
            right = [float(s.right) for s in said[:-1]] + [float(finish(lesson, config).as_meant)]
            found.append(
                Session(
                    family.name,
                    np.array([0.0 if s.doubts else s.confidence for s in said]),
                    np.array([float(s.left) for s in said]),
                    np.array(right),
                )
            )
    return found


def real(folder: Path, config: MappingConfig) -> list[Session]:
    """The study's sessions, one group a participant."""
    found = []
    for session in read_study(folder):
        states = [
            infer(session.task, session.target, session.assists[:k], config) for k in range(len(session.assists) + 1)
        ]
        used = set(session.task.used_objects)
        told = [{a.source_id for a in session.assists[:k]} for k in range(len(states))]
        found.append(
            Session(
                session.name.partition("_")[0],
                np.array([0.0 if e.doubted else e.confidence for e in states]),
                np.array([float(len(used - t)) for t in told]),
                np.array([float(session.solved_by(e.mapping.as_dict)) for e in states]),
            )
        )
    return found


def fit_correction(sessions: Sequence[Session], rounds: int = 30) -> Floats:
    """(3,) logistic regression of right on logit(confidence), log(1 + left) and 1, by Newton's steps."""
    confidence = np.concatenate([s.confidence for s in sessions])
    left = np.concatenate([s.left for s in sessions])
    right = np.concatenate([s.right for s in sessions])
    kept = (left > 0) & (confidence > 0)
    table = np.column_stack([[logit(c) for c in confidence[kept]], np.log1p(left[kept]), np.ones(kept.sum())])
    weights = np.array([1.0, 0.0, 0.0])
    for _ in range(rounds):
        said = 1.0 / (1.0 + np.exp(-table @ weights))
        curve = table.T @ (table * (said * (1.0 - said))[:, None]) + 1e-3 * np.eye(3)
        weights = weights + np.linalg.solve(curve, table.T @ (right[kept] - said))
    found: Floats = weights
    return found


def calibrate(sessions: Sequence[Session]) -> PromiseCalibration:
    """The correction from every other session, the critical scores from the rest."""
    slope, per_left, offset = (float(w) for w in fit_correction(sessions[::2]))
    rest = sessions[1::2]
    blank = PromiseCalibration(max(0.05, slope), per_left, offset, (0.0,), len(rest))
    critical = np.sort([_critical(blank, s) for s in rest])
    ranks = np.arange(KEPT_RANKS + 1) / KEPT_RANKS
    places = np.minimum(np.ceil(ranks * len(critical)).astype(int), len(critical)) - 1
    return replace(blank, critical=tuple(round(float(v), 6) for v in critical[np.maximum(places, 0)]))


def _critical(calibration: PromiseCalibration, session: Session) -> float:
    """Of a session; 1 when its end is wrong, which no threshold helps."""
    if not session.right[-1]:
        return 1.0
    return critical_of(_scores(calibration, session), [bool(r) for r in session.right])


def _scores(calibration: PromiseCalibration, session: Session) -> list[float]:
    return [calibration.score(float(c), int(k)) for c, k in zip(session.confidence, session.left, strict=True)]


def stops(sessions: Sequence[Session], reached: Sequence[Sequence[bool]]) -> tuple[float, float]:
    """(share right, mean assists) when the robot goes on alone where it first may, else after the last assist."""
    places = [next((k for k, go in enumerate(flags) if go), len(flags) - 1) for flags in reached]
    right = np.mean([s.right[k] for s, k in zip(sessions, places, strict=True)])
    return float(right), float(np.mean(places))


def by_promise(sessions: Sequence[Session], calibration: PromiseCalibration, promise: float) -> tuple[float, float]:
    """(share right, mean assists) under a promise."""
    wanted = calibration.critical_score(promise)
    return stops(sessions, [[score > wanted for score in _scores(calibration, s)] for s in sessions])


def by_threshold(sessions: Sequence[Session], threshold: float) -> tuple[float, float]:
    """(share right, mean assists) with a fixed threshold."""
    return stops(sessions, [[float(c) >= threshold for c in s.confidence] for s in sessions])


def cheapest_fixed(sessions: Sequence[Session], right: float) -> float:
    """Mean assists of the best fixed threshold that is right at least as often; NaN when none is."""
    tried = [by_threshold(sessions, k / 200) for k in range(201)]
    return min((assists for share, assists in tried if share >= right - 1e-9), default=float("nan"))


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; returns 0."""
    parser = CommandParser(prog="promise", description=__doc__)
    parser.add_argument("--calibrate", type=at_least_one, default=250, help="sessions of each family to calibrate on")
    parser.add_argument("--report", type=at_least_one, default=1000, help="sessions of each family kept apart")
    parser.add_argument("--study", type=Path, help="the public study folder, for leaving one participant out")
    options = parser.parse_args(arguments)
    config, console = MappingConfig(strategy="evidence"), Console(width=120)
    calibration = calibrate(_mixed(simulated(Half.CHOOSE, options.calibrate, 301, config)))
    console.print(f"CALIBRATION = {calibration!r}", highlight=False)
    fresh = simulated(Half.CHOOSE, max(1, options.report // 4), 302, config)
    apart = simulated(Half.REPORT, options.report, 303, config)
    for name, sessions in (("same families, new sessions", fresh), ("families kept apart", apart)):
        for promise in PROMISES:
            right, assists = by_promise(sessions, calibration, promise)
            fixed = cheapest_fixed(sessions, right)
            console.print(
                f"{name} ({len(sessions)}): promise {promise}: right {right:.3f} with {assists:.2f} assists; "
                f"best fixed threshold of equal success {fixed:.2f}",
                highlight=False,
            )
    for group in dict.fromkeys(s.group for s in apart):
        own = [s for s in apart if s.group == group]
        console.print(f"  {group}: promise 0.95: right {by_promise(own, calibration, 0.95)[0]:.3f}", highlight=False)
    if options.study:
        people = real(options.study, config)
        for promise in PROMISES:
            found = []
            for who in dict.fromkeys(s.group for s in people):
                others = [s for s in people if s.group != who]
                own = [s for s in people if s.group == who]
                critical = sorted(_critical(calibration, s) for s in others)
                mixed = replace(calibration, critical=tuple(critical), sessions=len(others))
                found += [(by_promise([s], mixed, promise)) for s in own]
            right, assists = (float(np.mean([f[k] for f in found])) for k in (0, 1))
            fixed = cheapest_fixed(people, right)
            console.print(
                f"real, one participant left out: promise {promise}: right {right:.3f} with {assists:.2f} assists; "
                f"best fixed threshold of equal success {fixed:.2f}",
                highlight=False,
            )
    return 0


def _mixed(sessions: Sequence[Session]) -> list[Session]:
    """In random order, so that every part holds every family."""
    order = np.random.default_rng(0).permutation(len(sessions))
    return [sessions[int(k)] for k in order]


if __name__ == "__main__":
    raise SystemExit(main())
