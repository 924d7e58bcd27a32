"""The console's panels of text, as HTML: everything in them that came from elsewhere is escaped."""

from __future__ import annotations

from mbd_model.execution_progress import Status
from mbd_model.objects import SceneObject
from mbd_model.session import Phase, PromptKind
from mbd_model.task import StepKind, TaskStep

from mbd_console.actions import ACTIONS, Action, offered
from mbd_console.palette import color_of, safe
from mbd_console.state import ConsoleState, asks
from mbd_console.status.event_log import LogLine, Tone
from mbd_console.words.texts import ENGLISH, PageTexts
from mbd_console.words.things import described_in, operator_names


def _key(action: Action) -> str:
    return f"<kbd>{ACTIONS[action].key_label}</kbd>"


LOG_SHOWN = 60  # lines
PATH = tuple(p for p in Phase if p is not Phase.ABORTED)
MARKS = {
    Tone.PHASE: "▸",
    Tone.ROBOT: "R",
    Tone.TEACHER: "T",
    Tone.ACCEPTED: "✓",
    Tone.REFUSED: "✕",
    Tone.NOTE: "✎",
    Tone.MAPPING: "↦",
}

STATUS_MARKS = {Status.UNDER_WAY: "▶", Status.DONE: "✓", Status.FAILED: "✕", Status.LEFT_OUT: "–"}


def clock(seconds: float) -> str:
    """Minutes and seconds."""
    total = max(0, int(seconds))
    return f"{total // 60}:{total % 60:02d}"


def phase_bar(state: ConsoleState, texts: PageTexts = ENGLISH) -> str:
    """The phases in order, the present one marked."""
    now = state.phase
    label = f'class="phases" aria-label="{safe(texts("path"))}"'
    if now is Phase.ABORTED:
        words = safe(texts("short_ABORTED"))
        return f'<ol {label}><li class="now aborted" aria-current="step" data-phase="{now.name}">{words}</li></ol>'
    parts = []
    for phase in PATH:
        name = "now" if phase is now else "past" if now is not None and phase < now else ""
        current = ' aria-current="step"' if phase is now else ""
        which = f'data-phase="{phase.name}" title="{safe(texts(f"phase_{phase.name}"))}"'
        parts.append(f'<li class="{name}"{current} {which}>{safe(texts(f"short_{phase.name}"))}</li>')
    return f"<ol {label}>{''.join(parts)}</ol>"


def prompt_banner(
    state: ConsoleState, meant_step: int = -1, texts: PageTexts = ENGLISH, *, answered_here: bool = False
) -> str:
    """The robot's prompt, or which answer is being corrected; carries the question's number for the page's answers.

    Args:
        state: what the page shows.
        meant_step: step whose answer is corrected, -1 for none.
        texts: in which language; the robot's sentence is as it was published.
        answered_here: with a button for each object that the question names, where there is no picture of them.
    """
    if meant_step >= 0 and meant_step < len(state.steps):
        step = state.steps[meant_step]
        verb = texts("verb_pick" if step.kind is StepKind.PICK else "verb_place")
        text = texts("meant_prompt", step=step.index + 1, verb=verb, source=step.primary_object)
        kind = "meant"
    else:
        text = state.prompt.text if state.prompt else texts("waiting")
        kind = "question" if asks(state.prompt) and (state.asked or state.candidates) else "inform"
    hint = ""
    if kind == "question" and state.prompt is not None:
        hint = f'<span class="hint">{_hint(state.prompt.kind, texts)}</span>'
        hint += _candidates(state, texts) if answered_here else ""
    if kind == "meant":
        hint = texts("hint_meant", meant=_key(Action.MEANT), escape="<kbd>Esc</kbd>")
        hint = f'<span class="hint">{hint}</span>'
    elif kind == "inform":
        hint = f'<span class="hint">{_next_step(state, texts)}</span>'
    paused = f'<span class="paused">{safe(texts("paused"))}</span>' if state.session and state.session.paused else ""
    said = safe(texts("teacher_said", words=state.speech))
    speech = f'<span class="speech">{said}</span>' if state.speech else ""
    about = f'data-question="{state.question}" data-step="{state.prompt.step_index if state.prompt else -1}"'
    return (
        f'<div class="prompt {kind}" {about}><span class="who">{safe(texts("who_robot"))}</span>'
        f'<span class="text">{safe(text)}</span>{hint}{paused}{speech}</div>'
    )


def _next_step(state: ConsoleState, texts: PageTexts) -> str:
    """What goes on while the robot asks nothing, or what the operator can do where nothing does."""
    if state.phase is Phase.EXECUTE:
        return safe(state.progress.text) if state.progress else texts("hint_EXECUTE", next=_key(Action.NEXT))
    return texts("hint_ABORTED", pause=_key(Action.PAUSE)) if state.phase is Phase.ABORTED else ""


def _hint(kind: PromptKind, texts: PageTexts) -> str:
    """What the operator does to answer a prompt."""
    name = f"hint_{kind.name}"
    keys = {"yes": _key(Action.YES), "no": _key(Action.NO), "skip": _key(Action.SKIP)}
    return texts(name, **keys) if texts.has(name) else ""


def _candidates(state: ConsoleState, texts: PageTexts) -> str:
    """A button for each source object that a step in doubt may be about."""
    names = operator_names(state.task.source, texts) if state.task else {}
    buttons = "".join(
        f'<button type="button" data-object="{safe(i)}">{safe(names[i].nominative if i in names else i)} '
        f"<kbd>{number}</kbd></button>"
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


def steps_panel(state: ConsoleState, meant_step: int = -1, texts: PageTexts = ENGLISH) -> str:
    """The demonstrated steps, what each is believed to be about on the new table, and from whom."""
    scene = state.recorded.source if state.recording and state.recorded else state.task.source if state.task else None
    things = {o.object_id: o for o in scene.objects} if scene else {}
    rows = "".join(
        _step(state, s, things.get(s.primary_object), texts, meant=s.index == meant_step) for s in state.steps
    )
    title = safe(texts("recording_title" if state.recording else "steps_title"))
    if not rows:
        rows = f'<li class="none">{safe(texts("no_step" if state.recording else "nothing_shown"))}</li>'
    task = state.recorded if state.recording else state.task
    # While something is held, a recording always "ends" while holding: no problem yet.
    shown_problems = () if task is None or (state.recording and state.closed) else task.problems
    problems = "".join(f'<li class="problem">{safe(p)}</li>' for p in shown_problems)
    name = "live" if state.recording else "still"
    return f'<h2 class="{name}">{title}</h2><ol class="steps">{rows}{problems}</ol>'


def assists_panel(state: ConsoleState, texts: PageTexts = ENGLISH) -> str:
    """The assists in force, oldest first; the last is the one that undo withdraws."""
    assists = state.session.assists if state.session else ()
    if not assists:
        return ""
    rows = []
    for number, a in enumerate(assists, start=1):
        key = f"<kbd>{ACTIONS[Action.UNDO].key_label}</kbd>"
        withdrawn = number == len(assists) and offered(state, Action.UNDO)
        last = f"<small>{texts('withdrawn_by', key=key)}</small>" if withdrawn else ""
        how = texts(f"how_{a.kind.name}") + (texts("how_confirmed") if a.confirmed else "")
        target = f'<span class="assisted">{safe(a.target_id)}</span>'
        line = texts("assist_line", step=a.step_index + 1, source=safe(a.source_id), target=target, how=how)
        rows.append(f'<li class="assist"><b>{number}</b><span>{line}</span>{last}</li>')
    return f'<h2 class="still">{safe(texts("assists_title"))}</h2><ol class="given">{"".join(rows)}</ol>'


def _step(state: ConsoleState, step: TaskStep, thing: SceneObject | None, texts: PageTexts, *, meant: bool) -> str:
    assists = {a.source_id: a for a in state.session.assists} if state.session else {}
    assist = assists.get(step.primary_object)
    belief = state.estimate.executed.as_dict.get(step.primary_object) if state.estimate and state.target else None
    asked = state.asked is step
    assisted_here = assist is not None and assist.step_index == step.index
    if assist is not None:
        how = safe(texts("assisted" if assisted_here else "assisted_before"))
        part = f'<span class="assisted">→ {safe(assist.target_id)}</span><small>{how}</small>'
    elif belief is not None and state.phase in (Phase.ASSIST, Phase.EXECUTE, Phase.DONE):
        part = f'<span class="inferred">→ {safe(belief)}</span><small>{safe(texts("believed"))}</small>'
    else:
        part = "<span></span><small></small>"
    status = state.step_statuses[step.index] if state.step_statuses else Status.PLANNED
    number = STATUS_MARKS.get(status, str(step.index + 1))
    flags = {"asked": asked, "meant": meant, "correctable": assisted_here}
    names = " ".join([status.name.lower(), *(name for name, on in flags.items() if on)])
    swatch = color_of(thing) if thing else "transparent"
    words = described_in(thing, texts).label if thing else ""
    verb = safe(texts("verb_pick" if step.kind is StepKind.PICK else "verb_place"))
    # What a click does a key does too: the part that is pressed is one for the keyboard and for a screen reader.
    label = f"{verb}: {safe(texts('correct_step', step=step.index + 1))}"
    pressed = f' role="button" tabindex="0" aria-label="{label}"' if assisted_here else ""
    return (
        f'<li class="step {names}" data-step="{step.index}"><b>{number}</b>'
        f'<span class="verb"{pressed}>{verb}</span>'
        f'<i style="background:{swatch}"></i><span class="object">{safe(step.primary_object)} '
        f"<small>{safe(words)}</small></span>{part}</li>"
    )


def belief_line(state: ConsoleState, texts: PageTexts = ENGLISH) -> str:
    """In words: how sure, by what, after how many assists."""
    estimate = state.estimate
    if estimate is None or state.phase not in (Phase.ASSIST, Phase.EXECUTE, Phase.DONE):
        later = "mapping_aborted" if state.phase is Phase.ABORTED else "mapping_later"
        return f'<p class="belief">{safe(texts(later))}</p>'
    features = f" {texts('and')} ".join(texts(f"name_{f}") for f in estimate.winning) or texts("no_feature")
    assists = texts("one_assist") if estimate.num_assists == 1 else texts("assists", count=estimate.num_assists)
    name, words = ("enough", "sure_enough") if state.confident else ("", "not_sure")
    sure = f'<b class="{name}">{safe(texts(words))}</b>'
    doubt = ""
    if estimate.doubted is not None:
        source, target = estimate.doubted.source_id, estimate.doubted.target_id
        words = texts("doubted", source=safe(source), target=safe(target), doubt=f"{estimate.doubt:.2g}")
        doubt = f'<p class="doubt">{words}</p>'
    warnings = "".join(f'<p class="warning">{safe(w)}</p>' for w in estimate.warnings)
    value = f"<b>{estimate.confidence:.3g}</b>"
    line = texts("belief", value=value, assists=safe(assists), features=f"<b>{safe(features)}</b>")
    return f'<p class="belief">{sure}: {line}</p>{doubt}{warnings}'


def log_panel(state: ConsoleState, texts: PageTexts = ENGLISH) -> str:
    """The event log, newest first."""
    lines = "".join(_log_line(line, state.began) for line in state.log[:LOG_SHOWN])
    return f'<h2>{safe(texts("events"))}</h2><ul class="log">{lines}</ul>'


def _log_line(line: LogLine, began: float) -> str:
    return (
        f'<li class="{line.tone}"><time>{clock(line.at - began)}</time><i>{MARKS[line.tone]}</i>'
        f"<b>{safe(line.speaker)}</b><span>{safe(line.text)}</span></li>"
    )
