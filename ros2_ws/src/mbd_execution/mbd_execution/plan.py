"""The plan: which target object goes where, in the order of the demonstration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.objects import Scene
from mbd_model.task import Task

from mbd_execution.demonstrated_transfers import DemonstratedTransfer, standing, transfers


@dataclass(frozen=True)
class Transfer:
    """One target object to pick up and set down.

    Attributes:
        shown: what the demonstration did.
        held: id of the target object to move; "" when the mapping has none.
        receiver: id of the target object it goes onto or into, None for the table; "" when the mapping has none.
    """

    shown: DemonstratedTransfer
    held: str
    receiver: str | None

    @property
    def problem(self) -> str:
        """Why it cannot be done, "" when nothing speaks against it."""
        if not self.held:
            return f"no new object plays {self.shown.picked.object_id}'s part"
        if self.receiver == "" and self.shown.receiver is not None:
            return f"no new object plays {self.shown.receiver.object_id}'s part"
        if self.receiver == self.held:
            return f"{self.held} cannot be put onto itself"
        return ""

    @property
    def problem_step(self) -> int:
        """Index of the step the problem is about."""
        return self.shown.pick if not self.held else self.shown.place


@dataclass(frozen=True)
class Plan:
    """What to do on which table.

    Attributes:
        transfers: in order.
        table: where the target objects are before it.
        num_steps: of the task.
    """

    transfers: tuple[Transfer, ...]
    table: TrackedObjects
    num_steps: int


def plan(task: Task, target: Scene, mapping: Mapping[str, str]) -> Plan:
    """The plan of doing the complete task on the target objects.

    Args:
        task: as demonstrated.
        target: the target objects as seen.
        mapping: source id -> target id; objects it leaves out, or that the scene does not have, become a problem of
            the transfers that need them.
    """
    known = set(target.ids)

    def counterpart(source_id: str) -> str:
        target_id = mapping.get(source_id, "")
        return target_id if target_id in known else ""

    found = tuple(
        Transfer(
            shown,
            counterpart(shown.picked.object_id),
            None if shown.receiver is None else counterpart(shown.receiver.object_id),
        )
        for shown in transfers(task)
    )
    return Plan(found, standing(target), len(task.steps))
