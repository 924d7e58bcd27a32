"""``chaos``: complete sessions whose nodes are killed, stopped, interrupted and cut off; counts which survive it."""

from __future__ import annotations

import argparse
import csv
import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero, at_least_one
from mbd_model.errors import MbdError
from mbd_model.folders import make_folder
from rich.console import Console

from mbd_bringup.chaos.faults import OF_CAMERA, OF_NETWORK, FaultKind, PlannedFault, draw_sessions
from mbd_bringup.chaos.processes_at_fault import in_own_network, own_network
from mbd_bringup.chaos.verdict import SessionFindings, faults_of_result, findings_of
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.ros.chaos.disturbed_session import DisturbedSession, disturbed_session, undisturbed

TASKS = ("sorting", "lunch_packing", "stacking", "dish_sorting", "assembly")


@dataclass(frozen=True)
class ChaosOptions:
    """What is tried.

    Attributes:
        sessions: how many.
        each: faults in each.
        seed: of the faults; session k is laid from seed + k.
        kinds: of faults.
        tasks: of the cell, in turn.
        execute: whether the robot executes the task.
        robot, camera: profiles of those that the cell plays; "" for the suite's own topics.
        out: folder for the sessions and the table.
        timeout: of one session [s].
    """

    sessions: int
    each: int
    seed: int
    kinds: tuple[FaultKind, ...]
    tasks: tuple[str, ...]
    execute: bool
    robot: str
    camera: str
    out: Path
    timeout: float

    def session(self, number: int) -> SessionOptions:
        """Of a session, every step of which is asked about: its course is the same whatever perception measures."""
        task = self.tasks[number % len(self.tasks)]
        # A session of the same task and seed is undisturbed for several.
        seed = self.seed + (number // len(self.tasks)) % 2
        return SessionOptions(
            f"chaos_{number}", self.out / f"session_{number}", task=task, seed=seed, threshold=1.0, speed=0.0,
            execute=self.execute, console=True, markers=True, robot=self.robot, camera=self.camera, port=_port(number),
        )  # fmt: skip

    @property
    def victims(self) -> tuple[str, ...]:
        """Every node of such a session."""
        return tuple(spec.executable for spec in session_nodes(self.session(0)))


_CONSOLE = Console(soft_wrap=True, highlight=False, markup=False)


def _say(text: str) -> None:
    _CONSOLE.print(text)
    _CONSOLE.file.flush()


def _port(number: int) -> int:
    return 18200 + (os.getpid() + number) % 800


@dataclass(frozen=True)
class ChaosResult:
    """One session: what happened to it, and what is wrong with it, a sentence each."""

    options: SessionOptions
    went: DisturbedSession
    wrong: tuple[str, ...]


class ChaosTrials:
    """Runs one session after the other, and writes the table after each.

    Args:
        options: what is tried.

    Raises:
        MbdError: more faults than a session has room for, or its folder holds sessions.
    """

    def __init__(self, options: ChaosOptions) -> None:
        self._options = options
        if (old := options.session(0).folder).exists():
            raise MbdError(f"{old} is there already, and no session is overwritten; give another folder by --out")
        self._plans = draw_sessions(
            options.sessions,
            options.each,
            options.kinds,
            options.victims,
            seed=options.seed,
            execute=options.execute,
        )
        self._expected: dict[tuple[str, int], SessionFindings] = {}
        self.results: list[ChaosResult] = []

    def run(self) -> None:
        """Run them all."""
        for number, faults in enumerate(self._plans):
            session = self._options.session(number)
            expected = self._undisturbed(session)
            _say(f"session {number}: {session.task}, seed {session.seed}")
            went = disturbed_session(session, faults, self._options.timeout, lambda text: _say(f"  {text}"))
            wrong = faults_of_result(session.bag, went.phase, expected, went.replies)
            wrong = tuple(w for w in (went.problem, *wrong) if w)
            if went.hanging:
                wrong = (*wrong, f"did not end when asked to: {', '.join(went.hanging)}")
            self.results.append(ChaosResult(session, went, wrong))
            _say(f"  {'; '.join(wrong) if wrong else 'as undisturbed'} ({went.seconds:.0f} s)")
            self._write()

    def _undisturbed(self, session: SessionOptions) -> SessionFindings:
        key = session.task, session.seed
        if key not in self._expected:
            name = f"undisturbed_{session.task}_{session.seed}"
            folder = self._options.out / name
            if not (folder / "bag" / "metadata.yaml").exists():
                took = undisturbed(replace(session, session=name, folder=folder), self._options.timeout).seconds
                _say(f"undisturbed: {session.task}, seed {session.seed} ({took:.0f} s)")
            self._expected[key] = findings_of(folder / "bag")
        return self._expected[key]

    def _write(self) -> None:
        with (self._options.out / "chaos.csv").open("w", newline="") as stream:
            table = csv.writer(stream)
            table.writerow(
                ["session", "task", "seed", "mark", "fault", "victim", "delay_s", "lasts_s", "struck", "session_wrong"]
            )
            for result in self.results:
                o = result.options
                for faults, struck in ((result.went.struck, True), (result.went.missed, False)):
                    for f in faults:
                        table.writerow([
                            o.session, o.task, o.seed, f.mark, f.kind, f.victim, f"{f.delay:.2f}", f"{f.seconds:.2f}",
                            struck, "; ".join(result.wrong),
                        ])  # fmt: skip


def summary(results: Sequence[ChaosResult]) -> list[str]:
    """The table for people: by victim how often each fault struck, and how many sessions were as undisturbed."""
    struck: list[PlannedFault] = [f for r in results for f in r.went.struck]
    kinds = [k for k in FaultKind if any(f.kind is k for f in struck)]
    counts = Counter((f.victim or "all", f.kind) for f in struck)
    lines = [f"{'victim':15}" + "".join(f"{k:>11}" for k in kinds)]
    lines += [f"{v:15}" + "".join(f"{counts[v, k]:>11}" for k in kinds) for v in sorted({v for v, _ in counts})]
    lines.append(f"{'together':15}" + "".join(f"{sum(f.kind is k for f in struck):>11}" for k in kinds))
    missed = sum(len(r.went.missed) for r in results)
    right = sum(not r.wrong for r in results)
    lines.append(f"{len(struck)} faults in {len(results)} sessions ({missed} more had no chance to strike)")
    lines.append(f"{right} of {len(results)} sessions ended with the findings of an undisturbed one, and nothing lost")
    return lines


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = CommandParser(prog="chaos", description=__doc__)
    parser.add_argument("--sessions", type=at_least_one, default=10, help="how many sessions (default 10)")
    parser.add_argument("--each", type=at_least_one, default=10, help="faults in each (default 10)")
    parser.add_argument("--seed", type=int, default=1, help="of the faults and the sessions (default 1)")
    parser.add_argument("--faults", nargs="+", choices=tuple(FaultKind), help="kinds (default: all that can be)")
    parser.add_argument("--tasks", nargs="+", choices=TASKS, default=["sorting"], help="in turn (default sorting)")
    parser.add_argument("--execute", action="store_true", help="have the robot execute the task, too")
    parser.add_argument("--robot", default="", help="profile of a robot that the cell plays: its node is a victim, too")
    parser.add_argument("--camera", default="", help="profile of a camera that the cell plays, alike")
    parser.add_argument("--timeout", type=above_zero, default=900.0, help="give a session up after so many seconds")
    parser.add_argument("--out", type=Path, required=True, help="folder that takes the sessions and chaos.csv")
    return parser.parse_args(words)


def _interrupt(number: int, frame: object) -> None:
    # Once: a second one must not break off the ending of the nodes. Also where SIGINT came inherited as ignored.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise KeyboardInterrupt


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 0 when every session survived, 1 when one did not, 2 for words that cannot be used."""
    given = _arguments(words)
    if words is None:
        signal.signal(signal.SIGINT, _interrupt)
        signal.signal(signal.SIGTERM, _interrupt)
    kinds = tuple(FaultKind(k) for k in given.faults or FaultKind)
    if set(kinds) & set(OF_NETWORK) and not in_own_network():
        if words is None:
            own_network([sys.executable, *sys.orig_argv[1:]])
        _say("not tried: network, which takes root, `unshare` and `ip` (a network namespace of its own)")
        kinds = tuple(k for k in kinds if k not in OF_NETWORK)
    if not given.camera and set(kinds) & set(OF_CAMERA):
        _say("not tried: camera, which takes --camera PROFILE (e.g. realsense)")
        kinds = tuple(k for k in kinds if k not in OF_CAMERA)
    begun = time.monotonic()
    try:
        make_folder(given.out)
        trials = ChaosTrials(
            ChaosOptions(
                given.sessions,
                given.each,
                given.seed,
                kinds,
                tuple(given.tasks),
                given.execute,
                given.robot,
                given.camera,
                given.out.absolute(),
                given.timeout,
            )
        )
        trials.run()
    except (MbdError, OSError) as error:
        sys.stderr.write(f"chaos: {error}\n")
        raise SystemExit(2) from None
    except KeyboardInterrupt:
        sys.stderr.write("chaos: interrupted; every node was ended\n")
        raise SystemExit(130) from None
    _say("\n".join(summary(trials.results)))
    _say(f"{time.monotonic() - begun:.0f} s; every fault is in {given.out / 'chaos.csv'}")
    raise SystemExit(1 if any(r.wrong for r in trials.results) else 0)
