"""Which faults befall a session, and when: drawn from a seed, spread over what happens in a session."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.session import Phase

_LONGEST_DELAY = 1.0  # [s] from a mark to its fault
_SHORTEST, _LONGEST = 1.0, 4.0  # [s] that a fault lasts which has an end
_WORDS, _ESTIMATES, _MOTIONS = 6, 6, 4  # of the tasks with the fewest


class FaultKind(StrEnum):
    """What happens."""

    KILL = "kill"  # SIGKILL: kill -9, the kernel's killer of processes, a crash
    STOP = "stop"  # SIGSTOP, and SIGCONT some seconds later: a process that gets no processor time
    INTERRUPT = "interrupt"  # SIGINT
    TERMINATE = "terminate"  # SIGTERM
    CLOCK = "clock"  # one message on /clock an hour ahead
    DISK = "disk"  # no file of any node may grow for some seconds
    CAMERA = "camera"  # the camera's node is stopped for some seconds
    NETWORK = "network"  # the network of all nodes is down for some seconds


# Those that befall one node each.
OF_ONE_NODE = (FaultKind.KILL, FaultKind.STOP, FaultKind.INTERRUPT, FaultKind.TERMINATE)
# Those that need more than a session of the simulated cell: its camera played as a real one; a network of its own.
OF_CAMERA, OF_NETWORK = (FaultKind.CAMERA,), (FaultKind.NETWORK,)


@dataclass(frozen=True)
class PlannedFault:
    """One fault.

    Attributes:
        mark: what has to happen before it, as `marks` names it.
        kind: what it is.
        victim: the node it befalls; "" where it befalls all.
        delay: from the mark to the fault, by the wall clock [s].
        seconds: that it lasts, by the wall clock [s]; 0.0 where it has no end of its own.
    """

    mark: str
    kind: FaultKind
    victim: str
    delay: float
    seconds: float


def marks(*, execute: bool) -> tuple[str, ...]:
    """What surely happens in a session that asks about every step: phases, the teacher's words, estimates, motions.

    Args:
        execute: whether the robot executes the task at last.
    """
    phases = [f"phase {p.name}" for p in (Phase.OBSERVE_SOURCE, Phase.DEMONSTRATE)]
    later = [f"phase {p.name}" for p in (Phase.TUCK_AND_CLEAR, Phase.OBSERVE_TARGET, Phase.ASSIST)]
    words = [f"word {k}" for k in range(1, _WORDS + 1)]
    estimates = [f"estimate {k}" for k in range(_ESTIMATES)]
    last = [f"phase {Phase.EXECUTE.name}", *(f"motion {k}" for k in range(1, _MOTIONS + 1))] if execute else []
    return (*phases, *words, *later, *estimates, *last)


def draw_sessions(
    sessions: int, each: int, kinds: Sequence[FaultKind], victims: Sequence[str], *, seed: int, execute: bool
) -> tuple[tuple[PlannedFault, ...], ...]:
    """The faults of each session.

    Every node is a victim about as often as every other, of every kind alike; two of three faults are a `KILL` where
    that is among the kinds.

    Args:
        sessions: how many.
        each: faults in each.
        kinds: that may occur.
        victims: names of the nodes.
        seed: decides.
        execute: see `marks`.

    Raises:
        MbdError: more faults than marks.
    """
    places = marks(execute=execute)
    if not 0 < each <= len(places):
        raise MbdError(f"{each} faults in a session; expected 1 to {len(places)}, one at each thing that happens in it")
    rng = np.random.default_rng(seed)
    drawn = _kinds(kinds, rng)
    by_kind = {kind: _victims(kind, victims, rng) for kind in kinds}
    plans = []
    for _ in range(sessions):
        chosen = sorted(rng.choice(len(places), size=each, replace=False).tolist())
        plans.append(tuple(_fault(places[k], next(drawn), by_kind, rng) for k in chosen))
    return tuple(plans)


def _fault(
    mark: str, kind: FaultKind, victims: dict[FaultKind, Iterator[str]], rng: np.random.Generator
) -> PlannedFault:
    lasting = kind in (FaultKind.STOP, FaultKind.DISK, FaultKind.CAMERA, FaultKind.NETWORK)
    seconds = float(rng.uniform(_SHORTEST, _LONGEST)) if lasting else 0.0
    return PlannedFault(mark, kind, next(victims[kind]), float(rng.uniform(0.0, _LONGEST_DELAY)), seconds)


def _kinds(kinds: Sequence[FaultKind], rng: np.random.Generator) -> Iterator[FaultKind]:
    others = [k for k in kinds if k is not FaultKind.KILL]
    if not others or FaultKind.KILL not in kinds:
        yield from itertools.cycle(kinds)
    while True:
        for other in rng.permutation(np.array(others, dtype=object)):
            turn = [FaultKind.KILL, FaultKind.KILL, other]
            rng.shuffle(turn)
            yield from turn


def _victims(kind: FaultKind, victims: Sequence[str], rng: np.random.Generator) -> Iterator[str]:
    if kind is FaultKind.CAMERA:
        return itertools.repeat("camera")
    if kind not in OF_ONE_NODE:
        return itertools.repeat("")
    return _in_turn(list(victims), rng)


def _in_turn(victims: list[str], rng: np.random.Generator) -> Iterator[str]:
    while True:
        rng.shuffle(victims)
        yield from victims
