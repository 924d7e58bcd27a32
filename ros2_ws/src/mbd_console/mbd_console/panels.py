"""The console's panels of text, as HTML: everything in them that came from elsewhere is escaped."""

from __future__ import annotations

from mbd_model.execution_progress import Status
from mbd_model.objects import SceneObject
from mbd_model.session import Phase, PromptKind
from mbd_model.task import StepKind, TaskStep
from mbd_model.task_words import described, names_in

from mbd_console.actions import ACTIONS, Action
from mbd_console.palette import GOOD, color_of, safe
from mbd_console.state import ConsoleState, LogLine, Tone, asks, phase_name


def _key(action: Action) -> str:
    return f"<kbd>{ACTIONS[action].key_label}</kbd>"


LOG_SHOWN = 60  # lines
PATH = tuple(p for p in Phase if p is not Phase.ABORTED)
SHORT = {
    Phase.OBSERVE_SOURCE: "Source",
    Phase.DEMONSTRATE: "Demonstrate",
    Phase.TUCK_AND_CLEAR: "Clear",
    Phase.OBSERVE_TARGET: "Target",
    Phase.ASSIST: "Assist",
    Phase.EXECUTE: "Execute",
    Phase.DONE: "Done",
}
MARKS = {
    Tone.PHASE: "▸",
    Tone.ROBOT: "R",
    Tone.TEACHER: "T",
    Tone.ACCEPTED: "✓",
    Tone.REFUSED: "✕",
    Tone.NOTE: "✎",
    Tone.MAPPING: "↦",
}

# What the operator does to answer a prompt; none for information.
HINTS = {
    PromptKind.WHAT_DO_I_USE: "click the object handed over, or press its number",
    PromptKind.WHERE_DO_I_GO: "click the object, or the place, pointed at, or press its number",
    PromptKind.CONFIRM_ASSIST: f"yes {_key(Action.YES)}, no {_key(Action.NO)}, or click the object meant",
    PromptKind.IS_THIS_IT: f"yes {_key(Action.YES)}, no {_key(Action.NO)}, or click the object",
    PromptKind.WHICH_WAS_MEANT: f"choose one, or skip {_key(Action.SKIP)} to leave it in doubt",
    PromptKind.WHICH_OF_TWO: f"click the object, or no {_key(Action.NO)} for neither",
}

STATUS_MARKS = {Status.UNDER_WAY: "▶", Status.DONE: "✓", Status.FAILED: "✕", Status.LEFT_OUT: "–"}


def clock(seconds: float) -> str:
    """Minutes and seconds."""
    total = max(0, int(seconds))
    return f"{total // 60}:{total % 60:02d}"


def phase_bar(state: ConsoleState) -> str:
    """The phases in order, the present one marked."""
    now = state.phase
    if now is Phase.ABORTED:
        return f'<ol class="phases"><li class="now aborted" data-phase="{now.name}">Aborted</li></ol>'
    parts = []
    for phase in PATH:
        name = "now" if phase is now else "past" if now is not None and phase < now else ""
        current = ' aria-current="step"' if phase is now else ""
        which = f'data-phase="{phase.name}" title="{phase_name(phase)}"'
        parts.append(f'<li class="{name}"{current} {which}>{SHORT[phase]}</li>')
    return f'<ol class="phases">{"".join(parts)}</ol>'


def recorder_line(state: ConsoleState) -> str:
    """What the recorder has missed; nothing while that is nothing."""
    if not state.missed:
        return ""
    return f'<span class="missed" title="{safe(state.missed_words)}">{state.missed} messages not recorded</span>'


def prompt_banner(state: ConsoleState, meant_step: int = -1, *, answered_here: bool = False) -> str:
    """The robot's prompt, or which answer is being corrected; carries the question's number for the page's answers.

    Args:
        state: what the page shows.
        meant_step: step whose answer is corrected, -1 for none.
        answered_here: with a button for each object that the question names, where there is no picture of them.
    """
    if meant_step >= 0 and meant_step < len(state.steps):
        step = state.steps[meant_step]
        text = f"I meant… choose the object for step {step.index + 1} ({_verb(step)} {step.primary_object})"
        kind = "meant"
    else:
        text = state.prompt.text if state.prompt else "Waiting for the interaction node…"
        kind = "question" if asks(state.prompt) and (state.asked or state.candidates) else "inform"
    hint = ""
    if kind == "question" and state.prompt is not None:
        hint = f'<span class="hint">{HINTS[state.prompt.kind]}</span>'
        hint += _candidates(state) if answered_here else ""
    if kind == "inform" and state.phase is Phase.EXECUTE and state.progress is not None:
        hint = f'<span class="hint">{safe(state.progress.text)}</span>'
    paused = '<span class="paused">paused</span>' if state.session and state.session.paused else ""
    speech = f'<span class="speech">teacher: “{safe(state.speech)}”</span>' if state.speech else ""
    about = f'data-question="{state.question}" data-step="{state.prompt.step_index if state.prompt else -1}"'
    return (
        f'<div class="prompt {kind}" {about}><span class="who">robot</span>'
        f'<span class="text">{safe(text)}</span>{hint}{paused}{speech}</div>'
    )


def _candidates(state: ConsoleState) -> str:
    """A button for each source object that a step in doubt may be about."""
    names = names_in(state.task.source) if state.task else {}
    buttons = "".join(
        f'<button type="button" data-object="{safe(i)}">the {safe(names.get(i, i))} <kbd>{number}</kbd></button>'
        for number, i in enumerate(state.candidates, start=1)
    )
    return f'<span class="choosing candidates">{buttons}</span>' if buttons else ""


def last_reply(state: ConsoleState) -> str:
    """What became of the last thing anyone sent."""
    for line in state.log:
        if line.tone in (Tone.ACCEPTED, Tone.REFUSED):
            return (
                f'<div class="reply {line.tone}"><b>{MARKS[line.tone]} {safe(line.speaker)}</b> {safe(line.text)}</div>'
            )
    return '<div class="reply"></div>'


def steps_panel(state: ConsoleState, meant_step: int = -1) -> str:
    """The demonstrated steps, what each is believed to be about on the new table, and from whom."""
    scene = state.recorded.source if state.recording and state.recorded else state.task.source if state.task else None
    things = {o.object_id: o for o in scene.objects} if scene else {}
    rows = "".join(_step(state, s, things.get(s.primary_object), s.index == meant_step) for s in state.steps)
    title = "Recording…" if state.recording else "Demonstrated steps"
    if not rows:
        rows = f'<li class="none">{"no step yet" if state.recording else "nothing demonstrated yet"}</li>'
    task = state.recorded if state.recording else state.task
    # While something is held, a recording always "ends" while holding: no problem yet.
    shown_problems = () if task is None or (state.recording and state.closed) else task.problems
    problems = "".join(f'<li class="problem">{safe(p)}</li>' for p in shown_problems)
    name = "live" if state.recording else "still"
    return f'<h2 class="{name}">{title}</h2><ol class="steps">{rows}{problems}</ol>'


def assists_panel(state: ConsoleState) -> str:
    """The assists in force, oldest first; the last is the one that undo withdraws."""
    assists = state.session.assists if state.session else ()
    if not assists:
        return ""
    rows = []
    for number, a in enumerate(assists, start=1):
        last = (
            f"<small>withdrawn by <kbd>{ACTIONS[Action.UNDO].key_label}</kbd></small>" if number == len(assists) else ""
        )
        sure = ", confirmed" if a.confirmed else ""
        rows.append(
            f'<li class="assist"><b>{number}</b><span>step {a.step_index + 1}: {safe(a.source_id)} is '
            f'<span class="assisted">{safe(a.target_id)}</span>, {a.kind.name.lower()}{sure}</span>{last}</li>'
        )
    return f'<h2 class="still">Assists so far</h2><ol class="given">{"".join(rows)}</ol>'


def _verb(step: TaskStep) -> str:
    return "pick" if step.kind is StepKind.PICK else "place onto"


def _step(state: ConsoleState, step: TaskStep, thing: SceneObject | None, meant: bool) -> str:
    assists = {a.source_id: a for a in state.session.assists} if state.session else {}
    assist = assists.get(step.primary_object)
    belief = state.estimate.executed.as_dict.get(step.primary_object) if state.estimate and state.target else None
    asked = state.asked is step
    assisted_here = assist is not None and assist.step_index == step.index
    if assist is not None:
        how = "assisted" if assisted_here else "assisted before"
        part = f'<span class="assisted">→ {safe(assist.target_id)}</span><small>{how}</small>'
    elif belief is not None and state.phase in (Phase.ASSIST, Phase.EXECUTE, Phase.DONE):
        part = f'<span class="inferred">→ {safe(belief)}</span><small>believed</small>'
    else:
        part = "<span></span><small></small>"
    status = state.step_statuses[step.index] if state.step_statuses else Status.PLANNED
    number = STATUS_MARKS.get(status, str(step.index + 1))
    flags = {"asked": asked, "meant": meant, "correctable": assisted_here}
    names = " ".join([status.name.lower(), *(name for name, on in flags.items() if on)])
    swatch = color_of(thing) if thing else "transparent"
    words = described(thing) if thing else ""
    return (
        f'<li class="step {names}" data-step="{step.index}"><b>{number}</b>'
        f'<span class="verb">{_verb(step)}</span>'
        f'<i style="background:{swatch}"></i><span class="object">{safe(step.primary_object)} '
        f"<small>{safe(words)}</small></span>{part}</li>"
    )


def belief_line(state: ConsoleState) -> str:
    """In words: how sure, by what, after how many assists."""
    estimate = state.estimate
    if estimate is None or state.phase not in (Phase.ASSIST, Phase.EXECUTE, Phase.DONE):
        return '<p class="belief">The mapping comes when the new objects were seen.</p>'
    features = " and ".join(f.replace("_", " ") for f in estimate.winning) or "no feature"
    assists = "1 assist" if estimate.num_assists == 1 else f"{estimate.num_assists} assists"
    sure = f'<b style="color:{GOOD}">Sure enough to go on alone</b>' if state.confident else "<b>Not sure yet</b>"
    doubt = ""
    if estimate.doubted is not None:
        doubted = f"{safe(estimate.doubted.source_id)} is {safe(estimate.doubted.target_id)}"
        doubt = f'<p class="doubt">Doubted: {doubted} (probably wrong: {estimate.doubt:.2g})</p>'
    warnings = "".join(f'<p class="warning">{safe(w)}</p>' for w in estimate.warnings)
    return (
        f'<p class="belief">{sure}: confidence <b>{estimate.confidence:.3g}</b> after {assists}, '
        f"by <b>{safe(features)}</b></p>{doubt}{warnings}"
    )


def log_panel(state: ConsoleState) -> str:
    """The event log, newest first."""
    lines = "".join(_log_line(line, state.began) for line in state.log[:LOG_SHOWN])
    return f'<h2>Events</h2><ul class="log">{lines}</ul>'


def _log_line(line: LogLine, began: float) -> str:
    return (
        f'<li class="{line.tone}"><time>{clock(line.at - began)}</time><i>{MARKS[line.tone]}</i>'
        f"<b>{safe(line.speaker)}</b><span>{safe(line.text)}</span></li>"
    )
