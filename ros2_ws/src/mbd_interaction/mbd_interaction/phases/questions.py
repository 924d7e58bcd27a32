"""What the robot asks next, and how."""

from __future__ import annotations

from mbd_model.assists import Assist
from mbd_model.estimate import QuestionKind
from mbd_model.session import Prompt
from mbd_model.task import TaskStep

from mbd_interaction.config import QuestionOrder
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import EstimateReceived
from mbd_interaction.prompts import is_this_it, question, which_of_two

CLOSED = {QuestionKind.IS_THIS_IT: 1, QuestionKind.WHICH_OF_TWO: 2}  # how many target objects each names


def step_to_ask(dialogue: Dialogue, belief: EstimateReceived) -> TaskStep | None:
    """The open step to ask about next, None when there is none.

    It is the one insisted on; else the one the mapping would learn most from, if questions come in that order or it
    would be asked by naming objects; else the next of the task.
    """
    steps = dialogue.open_steps
    for step in steps:
        if step.index == dialogue.insist:
            return step
    estimate = belief.estimate
    by_estimate = dialogue.config.question_order is QuestionOrder.INFORMATIVE or _named(dialogue, belief)
    if by_estimate and estimate is not None:
        for step in steps:
            if step.primary_object == estimate.next_question:
                return step
    return steps[0] if steps else None


def question_about(dialogue: Dialogue, step: TaskStep, belief: EstimateReceived) -> Prompt:
    """The question about a step: as the mapping would learn most, where that is allowed, else the paper's open one."""
    named, estimate = _named(dialogue, belief), belief.estimate
    if named and estimate is not None and step.primary_object == estimate.next_question:
        if estimate.question_kind is QuestionKind.IS_THIS_IT:
            return is_this_it(step, named[0])
        return which_of_two(step, named[0], named[1])
    return question(step)


def _named(dialogue: Dialogue, belief: EstimateReceived) -> tuple[str, ...]:
    """The target objects the next question should name; () to ask openly."""
    estimate = belief.estimate
    if estimate is None or estimate.question_kind not in dialogue.config.question_kinds:
        return ()
    named = estimate.question_targets
    known = set(dialogue.target.ids) if dialogue.target else set()
    denied = {d.target_id for d in dialogue.denials if d.source_id == estimate.next_question}
    # What was denied once is not asked again: the open question tells more than a second no.
    fits = len(named) == CLOSED.get(estimate.question_kind, 0) and known.issuperset(named) and not denied & set(named)
    return named if fits else ()


def assist_to_confirm(dialogue: Dialogue) -> Assist | None:
    """The assist that has to be asked about before the robot goes on alone; None when it may.

    It is the one the estimate doubts, else the first that the mapping to be carried out contradicts. One that was
    confirmed, or asked about and left as given, is not asked about again.
    """
    belief = dialogue.belief
    if belief is None or belief.estimate is None:
        return None
    asked = dialogue.kept_unconfirmed
    unconfirmed = [a for a in dialogue.assists if not a.confirmed and (a.source_id, a.target_id) not in asked]
    doubted = belief.estimate.doubted
    if doubted is not None:
        for assist in unconfirmed:
            if (assist.source_id, assist.target_id) == (doubted.source_id, doubted.target_id):
                return assist
    executed = belief.estimate.executed.as_dict
    return next((a for a in unconfirmed if executed.get(a.source_id) != a.target_id), None)
