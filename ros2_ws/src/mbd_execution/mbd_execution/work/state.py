"""Everything about the work under way, as one frozen value."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.execution_progress import Failure, Purpose, Status
from mbd_model.objects import SceneObject

from mbd_execution.goals import Motion, ToolGoal
from mbd_execution.hand import HandConfig
from mbd_execution.placing import Held
from mbd_execution.plan import Plan, Transfer
from mbd_execution.work.failures import Trouble

# Begun courses of these are ended even while the robot is asked to stop: they are what stopping means.
STOPPING = frozenset({Purpose.RETURN, Purpose.LET_GO})


@dataclass(frozen=True)
class Course:
    """Motions towards one end.

    Attributes:
        purpose: what for.
        transfer: which it is part of; of a look, which comes after it.
        goal: where the hand closes or opens.
        motions: those still to come, the one under way first.
    """

    purpose: Purpose
    transfer: Transfer
    goal: ToolGoal
    motions: tuple[Motion, ...]


@dataclass(frozen=True)
class Carried:
    """What is in the hand, for which transfer, and where it came from."""

    held: Held
    transfer: Transfer
    origin: SceneObject


@dataclass(frozen=True)
class Done:
    """A transfer that was done, and where its object came from."""

    transfer: Transfer
    origin: SceneObject


@dataclass(frozen=True)
class Work:
    """Everything about the work.

    Attributes:
        plan: what to do.
        table: where the objects are believed to be.
        hand: the hand's measures.
        done: transfers done, in order.
        carried: what is in the hand.
        course: the motions under way.
        attempts: failed ones of the present pick, place, look or taking back.
        failure: what is asked about, once it failed for the last time.
        left_out: first steps of the transfers given up.
        statuses: of each step.
        tool: where the tool was last known to be.
        stopped: why nothing may move until a person resumes; "" when it may.
        looks: the table is looked at again before every step, and once at the end.
        looked: nothing was moved since the last look.
        parked: nothing was moved at all, and the arm is where it was when the target scene was seen.
        tries: (object, failure) for each time one happened, so that none is tried for ever.
        gone: ids of objects that the last look did not show.
        fallen: ids of objects that the last look showed lying.
        accepted: ids of objects that a person left as they are.
        noticed: what the last look showed to have changed, for people.
    """

    plan: Plan
    table: TrackedObjects
    hand: HandConfig
    done: tuple[Done, ...] = ()
    carried: Carried | None = None
    course: Course | None = None
    attempts: int = 0
    failure: Trouble | None = None
    left_out: frozenset[int] = frozenset()
    statuses: tuple[Status, ...] = ()
    tool: ToolGoal | None = None
    stopped: str = ""
    looks: bool = False
    looked: bool = False
    parked: bool = False
    tries: tuple[tuple[str, Failure], ...] = ()
    gone: frozenset[str] = frozenset()
    fallen: frozenset[str] = frozenset()
    accepted: frozenset[str] = frozenset()
    noticed: str = ""

    @property
    def wanted(self) -> tuple[Transfer, ...]:
        """The plan's transfers without those given up."""
        return tuple(t for t in self.plan.transfers if t.shown.pick not in self.left_out)

    @property
    def undo(self) -> Done | None:
        """The last transfer done, when the plan wants it otherwise now; above it nothing can stand."""
        wanted = self.wanted
        agree = 0
        while agree < min(len(self.done), len(wanted)) and same(self.done[agree].transfer, wanted[agree]):
            agree += 1
        return self.done[-1] if agree < len(self.done) else None

    @property
    def next_transfer(self) -> Transfer | None:
        """The first that is not done."""
        wanted = self.wanted
        return wanted[len(self.done)] if len(self.done) < len(wanted) else None

    @property
    def must_look(self) -> bool:
        """Whether the table has to be looked at before anything else is done."""
        return self.looks and not self.looked

    @property
    def finished(self) -> bool:
        """Nothing is left to do."""
        idle = self.course is None and self.carried is None and self.failure is None
        nothing = idle and self.undo is None and self.next_transfer is None
        return nothing and not (self.must_look and self.done)

    def others(self, *but: str | None) -> tuple[SceneObject, ...]:
        """The objects that stand on the table, without some."""
        return tuple(o for o in self.table.objects if o.object_id not in but and o.object_id not in self.gone)

    def tried(self, object_id: str, failure: Failure) -> tuple[Work, int]:
        """The work after that failure of that object, and how often it happened by now."""
        tries = (*self.tries, (object_id, failure))
        return replace(self, tries=tries), tries.count((object_id, failure))


def same(one: Transfer, other: Transfer) -> bool:
    """Whether two transfers move the same object to the same place for the same steps."""
    return (one.shown.pick, one.held, one.receiver) == (other.shown.pick, other.held, other.receiver)


def with_status(statuses: tuple[Status, ...], status: Status, *steps: int) -> tuple[Status, ...]:
    """The statuses with those of some steps changed."""
    return tuple(status if i in steps else s for i, s in enumerate(statuses))


def halted(work: Work, why: str) -> Work:
    """The work after a stop: no motion comes of it before ``released``, whatever happens meanwhile."""
    return replace(work, stopped=work.stopped or why or "stopped")
