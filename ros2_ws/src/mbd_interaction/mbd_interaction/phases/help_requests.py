"""What the robot needs a person for while it works alone: "t2 has fallen over: please set it upright and say yes".

The question is asked once the robot has tried what it can by itself. No assist is withdrawn for it: yes and no go to
the robot as a verdict, skip leaves the step out, and another object replaces the assist. Either way the list of assists
is published under a new stamp, so that the robot plans again from it.
"""

from __future__ import annotations

from dataclasses import replace

from mbd_model.assists import Assist, AssistKind
from mbd_model.execution_progress import Failure, Verdict
from mbd_model.session import Phase, PromptKind
from mbd_model.task import StepKind, TaskStep
from mbd_model.times import to_seconds

from mbd_interaction.dialogue import AskedQuestion, Dialogue, Outcome, enter, with_assists
from mbd_interaction.effects import PublishPrompt
from mbd_interaction.events import Event, ProgressReceived
from mbd_interaction.phases.assist_phase import consider
from mbd_interaction.phases.lateness import refuse_late
from mbd_interaction.prompts import PHASE_TEXT, put_it_right

# Failures that are answered by an object, as any step of the assist phase is.
BY_OBJECT = frozenset({Failure.NONE, Failure.NO_COUNTERPART})


def asks_for_help(dialogue: Dialogue) -> bool:
    """Whether the question asked is one of these."""
    return dialogue.question is not None and dialogue.question.kind is PromptKind.PUT_IT_RIGHT


def ask_for_help(dialogue: Dialogue, now: ProgressReceived, at: int) -> Outcome:
    """Ask about a step that failed for the last time."""
    prompt = put_it_right(dialogue.steps[now.step_index], now.text)
    waiting = replace(enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST]), verdict=Verdict.NONE)
    skipped = dialogue.skipped - {now.step_index}
    asked = replace(
        waiting,
        step_index=now.step_index,
        question=AskedQuestion(prompt.kind),
        detail=prompt.text,
        asked_at=at,
        skipped=skipped,
    )
    return Outcome(asked, (PublishPrompt(prompt),))


def judged(dialogue: Dialogue, event: Event, verdict: Verdict) -> Outcome:
    """YES or NO: the robot goes on by it."""
    step = _asked(dialogue, event)
    words = "put right" if verdict is Verdict.YES else "not as the robot believes"
    return replace(_go_on(replace(dialogue, verdict=verdict), event.at), confirmation=f"step {step.index + 1}: {words}")


def left_out(dialogue: Dialogue, event: Event) -> Outcome:
    """SKIP: the robot leaves the step out."""
    step = _asked(dialogue, event)
    skipped = replace(dialogue, skipped=dialogue.skipped | {step.index})
    return replace(_go_on(skipped, event.at), confirmation=f"step {step.index + 1} is left out")


def another(dialogue: Dialogue, event: Event, target_id: str) -> Outcome:
    """HANDED or POINTED: that object instead; the one in use already is the same as yes."""
    step = _asked(dialogue, event)
    source_id = step.primary_object
    belief = dialogue.belief
    used = belief.estimate.executed.as_dict.get(source_id) if belief and belief.estimate else None
    if used == target_id:
        return judged(dialogue, event, Verdict.YES)
    kind = AssistKind.HANDED if step.kind is StepKind.PICK else AssistKind.POINTED
    assist = Assist(source_id, target_id, step.index, kind, to_seconds(event.at), True)
    others = tuple(a for a in dialogue.assists if a.source_id != source_id)
    outcome = _go_on(replace(dialogue, assists=(*others, assist), verdict=Verdict.YES), event.at)
    return replace(outcome, confirmation=f"{source_id} corresponds to {target_id}")


def _asked(dialogue: Dialogue, event: Event) -> TaskStep:
    refuse_late(dialogue, event)
    return dialogue.steps[dialogue.step_index]


def _go_on(dialogue: Dialogue, at: int) -> Outcome:
    free = replace(dialogue, step_index=-1, question=None, insist=-1)
    again, published = with_assists(free, dialogue.assists, at)
    return consider(again, at, (published,))
