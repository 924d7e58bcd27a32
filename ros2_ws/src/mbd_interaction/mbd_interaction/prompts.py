"""The sentences of the robot's prompts."""

from __future__ import annotations

from mbd_model.assists import Assist, AssistKind
from mbd_model.session import Phase, Prompt, PromptKind
from mbd_model.task import StepKind, Task, TaskStep
from mbd_model.task_words import names_in

from mbd_interaction.dialogue import Dialogue

PHASE_TEXT = {
    Phase.OBSERVE_SOURCE: "Please lay out the source objects and tell me when the table is ready.",
    Phase.DEMONSTRATE: "Please guide my arm through the task; say 'close' and 'open' for the gripper.",
    Phase.TUCK_AND_CLEAR: "Thank you. I tuck my arm; please clear the table.",
    Phase.OBSERVE_TARGET: "Please lay out the new objects and tell me when the table is ready.",
    Phase.ASSIST: "Let me think about which new object plays which part.",
    Phase.EXECUTE: "I go on alone.",
    Phase.DONE: "The task is done. Thank you.",
    Phase.ABORTED: "The session was aborted.",
}


def question(step: TaskStep) -> Prompt:
    """The paper's question about a step (sec. 4.2)."""
    if step.kind is StepKind.PICK:
        text = f"What do I use now? (step {step.index + 1}: where you picked up {step.primary_object})"
        return Prompt(PromptKind.WHAT_DO_I_USE, text, step.index, step.primary_object)
    text = f"Where do I go next? (step {step.index + 1}: where you placed onto {step.primary_object})"
    return Prompt(PromptKind.WHERE_DO_I_GO, text, step.index, step.primary_object)


def confirmation(assist: Assist) -> Prompt:
    """The question about an assist that is doubted."""
    verb = "gave me" if assist.kind is AssistKind.HANDED else "pointed at"
    text = f"You {verb} {assist.target_id} for {assist.source_id}: is that so?"
    return Prompt(PromptKind.CONFIRM_ASSIST, text, assist.step_index, assist.source_id, (assist.target_id,))


def is_this_it(step: TaskStep, target_id: str) -> Prompt:
    """The question to be answered by yes or no."""
    text = f"Is {target_id} the one for {step.primary_object}? (step {step.index + 1})"
    return Prompt(PromptKind.IS_THIS_IT, text, step.index, step.primary_object, (target_id,))


def which_of_two(step: TaskStep, first: str, second: str) -> Prompt:
    """The question to be answered by one of two objects, or neither."""
    text = f"Which is the one for {step.primary_object}: {first} or {second}? (step {step.index + 1})"
    return Prompt(PromptKind.WHICH_OF_TWO, text, step.index, step.primary_object, (first, second))


def which_was_meant(task: Task, step: TaskStep) -> Prompt:
    """The question about a demonstrated step that may be about either of two source objects."""
    names = names_in(task.source)
    first, second = step.primary_object, step.runner_up
    what = "pick" if step.kind is StepKind.PICK else "put it onto"
    text = f"Did you {what} the {names.get(first, first)} or the {names.get(second, second)}? (step {step.index + 1})"
    return Prompt(PromptKind.WHICH_WAS_MEANT, text, step.index, first, source_ids=(first, second))


def put_it_right(step: TaskStep, text: str) -> Prompt:
    """What the robot needs a person for at a step; ``text`` says what went wrong and what to do."""
    return Prompt(PromptKind.PUT_IT_RIGHT, f"I need help: {text}.", step.index, step.primary_object)


def remaining_steps(dialogue: Dialogue) -> tuple[TaskStep, ...]:
    """The steps after the last one that was answered or skipped; all of them when a robot executes them."""
    if dialogue.config.execute:
        return dialogue.steps
    last = max([-1, *(a.step_index for a in dialogue.assists), *dialogue.skipped])
    return tuple(s for s in dialogue.steps if s.index > last)


def statement(dialogue: Dialogue) -> str:
    """What the robot is going to do alone, step by step, as it predicts."""
    belief = dialogue.belief
    if belief is None or belief.estimate is None:
        return "I go on alone as soon as I know which new object plays which part."
    executed, predicted = belief.estimate.executed, belief.estimate.mapping
    if executed.pairs != predicted.pairs:
        opening = f"I do as you told me, though I doubt it ({executed.score:.2g})."
    else:
        sure = f"({belief.estimate.confidence:.2g})"
        opening = f"I am confident {sure}." if belief.sure else f"Nothing is left to ask, though I am not sure {sure}."
    steps = remaining_steps(dialogue)
    if not steps:
        return f"{opening} You helped me with every step; nothing is left to do alone."
    mapping = executed.as_dict
    held = next((s.primary_object for s in reversed(dialogue.steps[: steps[0].index])), "")
    parts = []
    for step in steps:
        parts.append(f"step {step.index + 1} {_request(step, held, mapping)}")
        held = step.primary_object if step.kind is StepKind.PICK else ""
    return f"{opening} I go on alone: {'; '.join(parts)}."


def _request(step: TaskStep, held: str, mapping: dict[str, str]) -> str:
    """One step in terms of the target objects; ``held`` is the source object in the gripper before it."""
    target = mapping.get(step.primary_object)
    if target is None:
        return f"has no object for {step.primary_object}"
    if step.kind is StepKind.PICK:
        return f"pick {target} for {step.primary_object}"
    if step.primary_object == held:
        return f"put {target} down as {step.primary_object} was"
    return f"place onto {target} for {step.primary_object}"
