"""The participant's panels, as HTML: lay words only, no ids, no numbers but of who asks."""

from __future__ import annotations

from mbd_model.colors import ASSISTED
from mbd_model.session import Phase

from mbd_console.palette import INFERRED, safe
from mbd_console.state import ConsoleState
from mbd_console.words import sentences
from mbd_console.words.sentences import LayNames
from mbd_console.words.texts import PageTexts


def dialogue_panel(state: ConsoleState, texts: PageTexts, names: LayNames) -> str:
    """What the robot says, what is wanted of the participant, what the arm does."""
    question = sentences.asking(state) and not state.standing
    rows = (
        ("robot", "what_robot_says", sentences.robot_says(state, texts, names)),
        ("you", "what_you_do", sentences.you_do(state, texts)),
        ("arm", "what_arm_does", sentences.arm_does(state, texts, names)),
    )
    lines = "".join(
        f'<div class="said {name}"><dt>{safe(texts(who))}</dt><dd>{safe(words)}</dd></div>' for name, who, words in rows
    )
    # The number of the question tells pages apart that show another one.
    kind = "question" if question else "inform"
    return f'<dl class="prompt lay {kind}" data-question="{state.question}">{lines}</dl>'


def spoken(state: ConsoleState, texts: PageTexts, names: LayNames) -> str:
    """What is read aloud."""
    said = sentences.robot_says(state, texts, names)
    return f"{said} {sentences.you_do(state, texts)}" if sentences.asking(state) else said


def sure_panel(state: ConsoleState, texts: PageTexts) -> str:
    """A bar from "not sure" to "sure" with a mark from where on the robot goes on alone, and why on request."""
    level = sentences.sureness(state)
    words = texts(sentences.sure_words(state, level))
    share = 0.0 if level is None else level
    return (
        f'<h2 id="sure-title">{safe(texts("how_sure"))}</h2><div class="meter" role="meter" aria-valuemin="0" '
        f'aria-valuemax="100" aria-valuenow="{100 * share:.0f}" aria-valuetext="{safe(words)}" '
        f'aria-labelledby="sure-title"><div class="level{" enough" if share >= sentences.SURE_FROM else ""}" '
        f'style="width:{100 * share:.0f}%"></div><div class="mark" style="left:{100 * sentences.SURE_FROM:.0f}%"></div>'
        f'</div><div class="ends"><span>{safe(texts("bar_low"))}</span><b>{safe(words)}</b>'
        f"<span>{safe(texts('bar_high'))}</span></div>"
        f'<p class="mark-words" style="width:{100 * sentences.SURE_FROM:.0f}%">{safe(texts("bar_mark"))} '
        '<i aria-hidden="true">▲</i></p>'
    )


def plan_panel(state: ConsoleState, texts: PageTexts, names: LayNames) -> str:
    """What the robot is going to do, a sentence for each thing."""
    lines = sentences.plan(state, texts, names)
    rows = "".join(f"<li>{safe(line)}</li>" for line in lines)
    over = state.phase in (Phase.DONE, Phase.ABORTED)
    shown = f"<ul>{rows}</ul>" if rows else f"<p>{safe(texts('plan_over' if over else 'plan_later'))}</p>"
    return f"<h2>{safe(texts('plan_title'))}</h2>{shown}"


def why_panel(state: ConsoleState, texts: PageTexts) -> str:
    """Why, in words."""
    return f"<p>{safe(sentences.why(state, texts))}</p>"


def only_shown(texts: PageTexts) -> str:
    """What a finger on the picture is told, by static/participant.js: it points at nothing there."""
    return f'<p class="only-shown-words" data-words="{safe(texts("only_shown"))}"></p>'


def legend(texts: PageTexts) -> str:
    """What the two colours in the picture mean, each with its kind of line."""
    entries = ((ASSISTED, "legend_told", ""), (INFERRED, "legend_thought", "6 4"))
    items = "".join(
        f'<li><svg width="40" height="12" aria-hidden="true"><line x1="2" y1="6" x2="38" y2="6" stroke="{color}" '
        f'stroke-width="4" stroke-dasharray="{dashes}"/></svg> {safe(texts(words))}</li>'
        for color, words, dashes in entries
    )
    return f'<p>{safe(texts("legend"))}</p><ul class="legend">{items}</ul>'
