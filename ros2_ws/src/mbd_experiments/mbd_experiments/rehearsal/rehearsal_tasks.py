"""A plan's sessions as they are rehearsed: who errs how, and with which parameters of the mapping."""

from __future__ import annotations

from collections.abc import Mapping

from mbd_mapping.parameters import MAPPING
from mbd_model.errors import MbdError
from mbd_model.forms.reading import shipped_forms
from mbd_study.plan.schedule import PlannedSession, planned_sessions
from mbd_study.plan.study_plan import StudyPlan

from mbd_experiments.rehearsal.holding import HeldPlan, SlipRates, held_plan
from mbd_experiments.rehearsal.rehearsed_session import RehearsalTask
from mbd_experiments.simulated_participants.error_model import TABLE5, Intention, intentions

# Arguments of a session's launch file that mean something here.
_OF_MAPPING = ("strategy", "threshold")


def rehearsal_tasks(plan: StudyPlan, rates: SlipRates, seed: int) -> tuple[RehearsalTask, ...]:
    """Every session of a plan as it is held.

    Args:
        plan: of the study.
        rates: of slips.
        seed: of the rehearsal.

    Raises:
        MbdError: a task or an argument of the plan that cannot be rehearsed.
    """
    unknown = sorted(set(plan.tasks) - set(TABLE5))
    if unknown:
        raise MbdError(f"tasks {unknown} cannot be rehearsed: participants' errors are known for {sorted(TABLE5)}")
    number = {name: k for k, name in enumerate(plan.participants, start=1)}
    # In each condition again: who errs once may be right in the next.
    drawn: dict[tuple[str, str, str], Intention] = {}
    for place, condition in enumerate(plan.conditions):
        for meant in intentions(len(number), seed + 1000 * place, plan.tasks):
            drawn[condition, meant.participant, meant.task] = meant
    held = held_plan(planned_sessions(plan), rates, seed)
    by_person: dict[str, list[HeldPlan]] = {}
    for one in held:
        by_person.setdefault(one.planned.participant, []).append(one)
    forms = tuple(name for name in ("consent", "demographics", "nasa_tlx", "godspeed") if name in shipped_forms())
    tasks = []
    for one in held:
        planned, own = one.planned, by_person[one.planned.participant]
        same = [h for h in own if h.planned.condition == planned.condition]
        tasks.append(
            RehearsalTask(
                held=one,
                intention=drawn[planned.condition, f"p{number[planned.participant]}", planned.task],
                parameters=_mapping_words(planned),
                forms=forms,
                first=one is own[0],
                last=one is same[-1],
                rates=rates,
                study=plan.study,
                seed=seed,
            )
        )
    return tuple(tasks)


def _mapping_words(planned: PlannedSession) -> Mapping[str, str | float]:
    words: dict[str, str | float] = {}
    for name, _, value in (argument.partition(":=") for argument in planned.arguments):
        if name not in _OF_MAPPING:
            raise MbdError(f"the plan's argument '{name}' cannot be rehearsed; expected {' or '.join(_OF_MAPPING)}")
        try:
            words[name] = float(value) if name == "threshold" else value
        except ValueError:
            raise MbdError(f"the plan's argument threshold:={value} is not a number") from None
    MAPPING.values(dict(words))
    return words
