"""A session to whose nodes faults happen, and whose nodes come back as under ``ros2 launch``."""

from __future__ import annotations

import contextlib
import queue
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mbd_bag.session.recorded_session import RecordedReply
from mbd_model.errors import MbdError
from mbd_model.estimate import MappingEstimate
from mbd_model.execution_progress import Progress
from mbd_model.ros import conversions
from mbd_model.session import Phase
from rosgraph_msgs.msg import Clock

from mbd_bringup.chaos.faults import PlannedFault
from mbd_bringup.chaos.processes_at_fault import strike
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.chaos.person_beside import PersonBeside
from mbd_bringup.ros.follow import SessionEvent
from mbd_bringup.ros.live_session import OVER, LiveSession

RESPAWN_DELAY = 1.0  # [s] as in the launch file
_JUMP = 3600.0  # [s] that the clock is ahead for one message
_PATIENCE = 90.0  # [s] for the nodes to end: a machine that others use as well may give them none for half a minute
_CLOSING = 120.0  # [s] for a recorder that was killed last of all to come back, and close its bag


@dataclass
class DisturbedSession:
    """How a session with faults went.

    Attributes:
        phase: in which it ended; None before its first.
        seconds: that it took, by the wall clock.
        struck: the faults that happened, with the mark each.
        missed: those whose mark did not come, or whose victim was gone.
        restarts: how often a node was started again, by name.
        hanging: nodes that had to be killed at the end.
        replies: to wizard events, as they were received here.
        resumed: how often everything stood, and a person let it go on.
        problem: why it was given up; "" when it was not.
    """

    phase: Phase | None = None
    seconds: float = 0.0
    struck: list[PlannedFault] = field(default_factory=list)
    missed: list[PlannedFault] = field(default_factory=list)
    restarts: dict[str, int] = field(default_factory=dict)
    hanging: Sequence[str] = ()
    replies: list[RecordedReply] = field(default_factory=list)
    resumed: int = 0
    problem: str = ""


def disturbed_session(
    options: SessionOptions,
    faults: Sequence[PlannedFault],
    timeout: float,
    say: Callable[[str], object] = lambda _: None,
    watch: Callable[[LiveSession, SessionEvent], object] = lambda *_: None,
) -> DisturbedSession:
    """Lead one session to its end while faults happen to it.

    Args:
        options: of the session.
        faults: in any order, one a mark.
        timeout: by the wall clock, after which it is given up [s].
        say: takes a line for people about each fault.
        watch: gets each event, and the session.

    Raises:
        MbdError: a package is not built.
    """
    made, begun = DisturbedSession(), time.monotonic()
    with LiveSession(options) as live:
        run = _FaultsAtWork(live, faults, made, say)
        while live.phase not in OVER:
            run.look(watch)
            if time.monotonic() - begun > timeout:
                made.problem = f"given up after {timeout:g} s"
                break
        run.end_faults()
        made.seconds = time.monotonic() - begun
        closing = time.monotonic()
        while not made.problem and not run.closed(options.bag / "metadata.yaml"):
            run.look(watch)
            if time.monotonic() - closing > _CLOSING:
                made.problem = f"the bag was not closed {_CLOSING:g} s after the session's end"
        made.phase = live.phase
        made.hanging = live.processes.stop(patience=_PATIENCE)
    made.missed = [f for f in faults if f not in made.struck]
    return made


class _FaultsAtWork:
    """Watches a session, and does what is due."""

    def __init__(
        self, live: LiveSession, faults: Sequence[PlannedFault], made: DisturbedSession, say: Callable[[str], object]
    ) -> None:
        self._live, self._made, self._say = live, made, say
        self._waiting = {f.mark: f for f in faults}
        self._due: list[tuple[float, PlannedFault]] = []
        self._ends: list[tuple[float, Callable[[], None]]] = []
        self._died: dict[str, float] = {}
        self._words = self._motions = 0
        self._recorder_since = 0.0
        self._clock = live.follower.create_publisher(Clock, "/clock", 10)
        self._person = PersonBeside(live.follower)

    def look(self, watch: Callable[[LiveSession, SessionEvent], object]) -> None:
        """Take what happened, if anything did, and do what is due."""
        event: SessionEvent | None = None
        with contextlib.suppress(queue.Empty):
            event = self._live.follower.events.get(timeout=0.05)
        now = time.monotonic()
        if event is not None:
            self._live.phase = event.phase or self._live.phase
            if isinstance(event.fact, RecordedReply):
                self._made.replies.append(event.fact)
            if (fault := self._waiting.pop(self._mark(event), None)) is not None:
                self._due.append((now + fault.delay, fault))
            watch(self._live, event)
        if self._person.let_go_on(now):
            self._made.resumed += 1
            self._say("  a person lets the robot go on")
        self._strike_due(now)
        self._end_due(now)
        self._bring_back(now)

    def closed(self, metadata: Path) -> bool:
        """Whether the recorder that runs now has closed the bag; one interrupted closed it, too, and comes back."""
        if any(node.name == "recorder" for node in self._live.processes.dead()):
            return False
        try:
            return metadata.stat().st_mtime >= self._recorder_since
        except FileNotFoundError:
            return False

    def end_faults(self) -> None:
        """End those that still last, and let none begin any more."""
        self._waiting, self._due = {}, []
        self._end_due(float("inf"))

    def _mark(self, event: SessionEvent) -> str:
        if event.phase is not None:
            return f"phase {event.phase.name}"
        if event.speaker == "teacher":
            self._words += 1
            return f"word {self._words}"
        if isinstance(event.fact, Progress):
            self._motions += 1
            return f"motion {self._motions}"
        return f"estimate {event.fact.num_assists}" if isinstance(event.fact, MappingEstimate) else ""

    def _strike_due(self, now: float) -> None:
        for at, fault in list(self._due):
            if at > now:
                continue
            self._due.remove((at, fault))
            end = strike(fault, self._live.processes.nodes, self._jump)
            if end is None:
                self._say(f"{fault.mark}: {fault.victim} is not running")
                continue
            self._made.struck.append(fault)
            self._ends.append((now + fault.seconds, end))
            for_so_long = f" for {fault.seconds:.1f} s" if fault.seconds else ""
            self._say(f"{fault.mark}: {fault.kind} {fault.victim}{for_so_long}")

    def _end_due(self, now: float) -> None:
        for entry in [e for e in self._ends if e[0] <= now]:
            self._ends.remove(entry)
            entry[1]()

    def _bring_back(self, now: float) -> None:
        """Start nodes again that ended, as launch does whatever they ended by."""
        for node in self._live.processes.dead():
            died = self._died.setdefault(node.name, now)
            if now - died >= RESPAWN_DELAY:
                del self._died[node.name]
                self._made.restarts[node.name] = self._made.restarts.get(node.name, 0) + 1
                if node.name == "recorder":
                    self._recorder_since = time.time()
                self._live.processes.start(node.spec)

    def _jump(self) -> None:
        self._clock.publish(Clock(clock=conversions.time_to_msg(self._live.follower.clock_now + _JUMP)))


def undisturbed(options: SessionOptions, timeout: float) -> DisturbedSession:
    """The same session without a fault; raises MbdError when even that does not get to its end."""
    made = disturbed_session(options, (), timeout)
    if made.phase is not Phase.DONE:
        raise MbdError(
            f"a session without a fault ended in {made.phase} ({made.problem}); its logs are in {options.folder}"
        )
    return made
