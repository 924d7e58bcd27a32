"""The assist loop: wait for what the mapping infers, then ask about a step or go on alone (paper sec. 4.2, 7).

Before going on alone every assist that the robot doubts, or that the mapping it would carry out contradicts, is asked
about once: "You gave me t3 for s1: is that so?"
"""

from __future__ import annotations

from dataclasses import replace

from mbd_model.assists import Assist, Denial
from mbd_model.session import Phase, Prompt, PromptKind

from mbd_interaction.dialogue import AskedQuestion, Dialogue, Outcome, enter, with_assists
from mbd_interaction.effects import Effect, PublishPrompt, inform
from mbd_interaction.events import EstimateReceived, Event, TargetReceived, TaskReceived
from mbd_interaction.phases.questions import assist_to_confirm, question_about, step_to_ask
from mbd_interaction.prompts import PHASE_TEXT, confirmation, remaining_steps, statement

CHANGED = "The task or the new objects changed; I ask from the beginning."


def begin_assists(dialogue: Dialogue, at: int, detail: str = "") -> Outcome:
    """Enter ASSIST without assists."""
    fresh = replace(dialogue, skipped=frozenset(), yes_or_no=())
    entered = enter(fresh, Phase.ASSIST, detail or PHASE_TEXT[Phase.ASSIST])
    fresh, published = with_assists(entered, (), at, denials=())
    return consider(fresh, at, (published, inform(fresh.detail)))


def consider(dialogue: Dialogue, at: int, effects: tuple[Effect, ...] = ()) -> Outcome:
    """What to do in ASSIST now: wait for the estimate of the present assists, ask about a step, or go on alone."""
    if dialogue.paused:
        return Outcome(dialogue, effects)
    if dialogue.question is not None and dialogue.question.kind is PromptKind.PUT_IT_RIGHT:
        return Outcome(dialogue, effects)  # only a person's answer leads on
    belief = dialogue.belief
    if dialogue.task is None or dialogue.target is None or belief is None:
        missing = (
            "the task" if dialogue.task is None else "the target scene" if dialogue.target is None else "the mapping"
        )
        return Outcome(replace(dialogue, step_index=-1, question=None, detail=f"waiting for {missing}"), effects)
    step = step_to_ask(dialogue, belief)
    if step is None or (belief.sure and dialogue.insist < 0):
        return go_on(dialogue, at, effects)
    return _ask(dialogue, question_about(dialogue, step, belief), at, effects)


def _ask(dialogue: Dialogue, prompt: Prompt, at: int, effects: tuple[Effect, ...]) -> Outcome:
    question = AskedQuestion(prompt.kind, prompt.target_ids)
    asked = replace(
        dialogue, step_index=prompt.step_index, question=question, detail=prompt.text, asked_at=at, insist=-1
    )
    return Outcome(asked, (*effects, PublishPrompt(prompt)))


def go_on(dialogue: Dialogue, at: int, effects: tuple[Effect, ...] = ()) -> Outcome:
    """Go on alone, or back to ASSIST when an assist has to be asked about first."""
    if not _fits(dialogue):
        return begin_assists(dialogue, at, CHANGED)
    doubted = assist_to_confirm(dialogue)
    if doubted is None:
        return execute(dialogue, effects)
    waiting = dialogue
    if dialogue.phase is not Phase.ASSIST:
        waiting = enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST])
    if waiting.paused:
        return Outcome(waiting, effects)
    return _ask(waiting, confirmation(doubted), at, effects)


def execute(dialogue: Dialogue, effects: tuple[Effect, ...] = ()) -> Outcome:
    """Enter EXECUTE and state the rest of the task as predicted."""
    text, steps = statement(dialogue), remaining_steps(dialogue)
    executing = replace(enter(dialogue, Phase.EXECUTE, text), step_index=steps[0].index if steps else -1)
    return Outcome(executing, (*effects, inform(text)))


def estimate_received(dialogue: Dialogue, event: Event) -> Outcome:
    """ESTIMATE: remember it; in ASSIST it decides what comes next, if it came of the present inputs.

    In EXECUTE one that contradicts an assist, as of another strategy, leads back to ASSIST to ask about it.
    """
    if not isinstance(event, EstimateReceived):
        return Outcome(dialogue)
    waited = dialogue.belief is None
    updated = replace(dialogue, last_estimate=event)
    if waited and updated.belief and dialogue.phase is Phase.ASSIST:
        return consider(updated, event.at)
    if dialogue.phase is Phase.EXECUTE and updated.belief and (waited or assist_to_confirm(updated) is not None):
        return go_on(updated, event.at)  # the node came back during execution: what it does is stated again
    return Outcome(updated)


def overdue(dialogue: Dialogue, event: Event) -> Outcome:
    """OVERDUE: no estimate came; report where it should come from."""
    if dialogue.belief is not None or dialogue.paused:
        return Outcome(dialogue)
    text = f"I am still {dialogue.detail}: are the mapping and demonstration nodes running?"
    return Outcome(dialogue, (inform(text),))


def task_received(dialogue: Dialogue, event: Event) -> Outcome:
    """TASK: remember it; another one during the assists starts them over."""
    if not isinstance(event, TaskReceived):
        return Outcome(dialogue)
    known = dialogue.task is not None and dialogue.task_stamp != event.stamp
    return _input_received(replace(dialogue, task=event.task, task_stamp=event.stamp), event.at, known)


def target_received(dialogue: Dialogue, event: Event) -> Outcome:
    """TARGET: remember it; another one during the assists starts them over."""
    if not isinstance(event, TargetReceived):
        return Outcome(dialogue)
    known = dialogue.target is not None and dialogue.target_stamp != event.stamp
    return _input_received(replace(dialogue, target=event.scene, target_stamp=event.stamp), event.at, known)


def _fits(dialogue: Dialogue) -> bool:
    """Whether all that was claimed is about objects and steps there are, as far as they are known."""
    claims: tuple[Assist | Denial, ...] = (*dialogue.assists, *dialogue.denials)
    targets = set(dialogue.target.ids) if dialogue.target else {c.target_id for c in claims}
    sources = {s.primary_object for s in dialogue.steps} if dialogue.task else {c.source_id for c in claims}
    return all(c.target_id in targets and c.source_id in sources for c in claims)


def _input_received(dialogue: Dialogue, at: int, changed: bool) -> Outcome:
    if dialogue.phase not in (Phase.ASSIST, Phase.EXECUTE):
        return Outcome(dialogue)
    asks_what_is_not = dialogue.task is not None and dialogue.step_index >= len(dialogue.steps)
    if changed or not _fits(dialogue) or asks_what_is_not:
        return begin_assists(dialogue, at, CHANGED)
    if dialogue.phase is Phase.ASSIST and dialogue.step_index < 0:
        return consider(dialogue, at)
    return Outcome(dialogue)
