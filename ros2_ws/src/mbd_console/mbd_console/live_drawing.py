"""What lies over the live picture: an outline and a label on each object, clickable when one may be chosen."""

from __future__ import annotations

from mbd_model.colors import ASSISTED
from mbd_model.session import Phase
from mbd_model.task import StepKind

from mbd_console.actions import OBJECT_KEYS
from mbd_console.outlines import ObjectOutline, outlines
from mbd_console.palette import INFERRED, safe
from mbd_console.state import ConsoleState
from mbd_console.words.texts import ENGLISH, PageTexts
from mbd_console.words.things import described_in

LABEL_HEIGHT, LETTER = 24.0, 8.6  # [px of a 640 x 480 picture]


def live_overlay(state: ConsoleState, texts: PageTexts = ENGLISH, *, clickable: bool) -> str:
    """SVG over the live picture, "" before the camera is known.

    Args:
        state: what is known.
        texts: in which language.
        clickable: whether objects (and, when a place is asked for, the table) react; never for the participant.
    """
    if state.view is None:
        return ""
    width, height = state.view.size
    choosing = clickable and state.phase in (Phase.ASSIST, Phase.EXECUTE)
    asks_place = choosing and state.asked is not None and state.asked.kind is StepKind.PLACE
    table = _table(state, texts) if asks_place else ""
    roles = _roles(state)
    things = "".join(
        _object(o, roles, _key(state, o) if choosing else "", state.view.size, texts, choosing=choosing)
        for o in outlines(state.view, state.on_table)
    )
    return (
        f'<svg class="overlay{" choosing" if choosing else ""}" role="group" '
        f'aria-label="{safe(texts("objects_on_table"))}" viewBox="0 0 {width} {height}" '
        f'preserveAspectRatio="xMidYMid meet">{table}{things}</svg>'
    )


def _table(state: ConsoleState, texts: PageTexts) -> str:
    """The picture as what can be clicked; by keyboard the objects on it are chosen."""
    width, height = state.view.size if state.view else (0, 0)
    return (
        f'<rect class="table" data-place="1" width="{width}" height="{height}">'
        f"<title>{safe(texts('place_on_table'))}</title></rect>"
    )


def _roles(state: ConsoleState) -> dict[str, tuple[str, str]]:
    """Target id -> (source id it plays, colour): given by an assist, or predicted."""
    pairs = {}
    if state.phase in (Phase.ASSIST, Phase.EXECUTE):
        if state.estimate:
            pairs = {target: (source, INFERRED) for source, target in state.estimate.executed.pairs}
        if state.session:
            pairs |= {a.target_id: (a.source_id, ASSISTED) for a in state.session.assists}
    return pairs


def _key(state: ConsoleState, outline: ObjectOutline) -> str:
    ids = state.target.ids if state.target else ()
    place = ids.index(outline.thing.object_id) if outline.thing.object_id in ids else len(OBJECT_KEYS)
    return OBJECT_KEYS[place] if place < len(OBJECT_KEYS) else ""


def _object(
    outline: ObjectOutline,
    roles: dict[str, tuple[str, str]],
    key: str,
    size: tuple[int, int],
    texts: PageTexts,
    *,
    choosing: bool,
) -> str:
    name = outline.thing.object_id
    source, color = roles.get(name, ("", "#ffffff"))
    points = " ".join(f"{u:.1f},{v:.1f}" for u, v in outline.corners)
    assisted = color == ASSISTED
    text = f"{name} = {source}" if assisted else name
    u, v = outline.bottom
    badge = 20.0 if key else 0.0
    label = LETTER * len(text) + 14 + badge
    # Inside the picture, whatever the object does.
    left = min(max(u - label / 2, 2.0), size[0] - label - 2)
    top = min(v + 3, size[1] - LABEL_HEIGHT - 2)
    shown = (
        f'<rect class="key" x="{left + 3:.1f}" y="{top + 3:.1f}" width="18" height="18" rx="3"/>'
        f'<text class="keytext" x="{left + 12:.1f}" y="{top + 16.5:.1f}">{safe(key)}</text> '
        if key
        else ""
    )
    # A button for keyboard and screen reader while it can be chosen, else a part of the picture with a name.
    # Its name begins with what is seen on it, so that it can be said as well.
    named = f'aria-label="{safe(f"{key} {text}: {described_in(outline.thing, texts).label}".strip())}"'
    role = f'role="button" tabindex="0" {named}' if choosing else f'role="img" {named}'
    return (
        f'<g class="object" data-object="{safe(name)}" {role} style="--c:{color if assisted else "#ffffff"}">'
        f'<polygon class="halo" points="{points}"/><polygon class="line" points="{points}"/>'
        f'<rect class="label" x="{left:.1f}" y="{top:.1f}" width="{label:.1f}" height="{LABEL_HEIGHT}" rx="5"/>{shown}'
        f'<text class="name" x="{left + badge + (label - badge) / 2:.1f}" y="{top + 17:.1f}">{safe(text)}</text></g>'
    )
