"""The sessions that a plan means, participant by participant, in order."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from mbd_study.plan.orders import Order, balanced_at, orders
from mbd_study.plan.study_plan import PlanError, StudyPlan


@dataclass(frozen=True)
class PlannedSession:
    """One session to be held.

    Attributes:
        session: its name, and that of its folder: ``<participant>_<condition>_<task>``.
        participant: pseudonym.
        position: in the participant's own order, from 1.
        condition: that holds in it.
        task: to be demonstrated.
        seed: of a simulated cell; equal for equal plans.
        arguments: ``name:=value`` of its condition.
    """

    session: str
    participant: str
    position: int
    condition: str
    task: str
    seed: int
    arguments: tuple[str, ...] = ()


def planned_sessions(plan: StudyPlan) -> tuple[PlannedSession, ...]:
    """Every session of a plan in the order it is held; the same for the same plan.

    Raises:
        PlanError: two sessions would have one name.
    """
    people = len(plan.participants)
    # A stream of its own each, so that a task more does not change the order of the conditions.
    of_conditions, of_seeds = (np.random.default_rng([plan.seed, stream]) for stream in range(2))
    condition_orders = orders(plan.condition_order, len(plan.conditions), people, of_conditions)
    # Of each condition by itself, so that tasks and conditions are not confounded.
    task_orders = [
        iter(orders(plan.task_order, len(plan.tasks), people, np.random.default_rng([plan.seed, 2, number])))
        for number in range(len(plan.conditions))
    ]
    found: list[PlannedSession] = []
    for participant, conditions in zip(plan.participants, condition_orders, strict=True):
        position = 0
        for condition in conditions:
            for task in next(task_orders[condition]):
                position += 1
                names = (plan.conditions[condition], plan.tasks[task])
                found.append(
                    PlannedSession(
                        session="_".join((participant, *names)),
                        participant=participant,
                        position=position,
                        condition=names[0],
                        task=names[1],
                        seed=int(of_seeds.integers(2**31)),
                        arguments=plan.arguments.get(names[0], ()),
                    )
                )
    count = Counter(s.session for s in found)
    twice = [name for name, times in count.items() if times > 1]
    if twice:
        raise PlanError(f"two sessions would have the name {twice[0]!r}; rename a condition, a task or a participant")
    return tuple(found)


def imbalances(plan: StudyPlan) -> tuple[str, ...]:
    """Where the numbers of a plan leave its orders unbalanced, a sentence each; () where nowhere."""
    people = len(plan.participants)
    # Of BLOCKS each condition has its share of the people only.
    shares = len(plan.conditions) if plan.condition_order is Order.BLOCKS else 1
    sentences = []
    for what, kind, multiple in (
        ("conditions", plan.condition_order, balanced_at(plan.condition_order, len(plan.conditions))),
        ("tasks in each condition", plan.task_order, balanced_at(plan.task_order, len(plan.tasks)) * shares),
    ):
        if people % multiple and kind in (Order.WILLIAMS, Order.BLOCKS):
            sentences.append(
                f"the order of {what} ({kind}) is balanced for a multiple of {multiple} participants, and there are "
                f"{people}: {people + multiple - people % multiple} would do"
            )
    return tuple(sentences)
