"""The mapping between the pictures of both scenes, as SVG."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mbd_model.camera.view import CameraView
from mbd_model.colors import ASSISTED
from mbd_model.objects import Role, Scene, SceneObject

from mbd_console.outlines import ObjectOutline, Pixel, outlines
from mbd_console.palette import INFERRED, color_of, safe
from mbd_console.state import ConsoleState
from mbd_console.words.sentences import LayNames
from mbd_console.words.texts import ENGLISH, PageTexts
from mbd_console.words.things import described_in

PANEL, GAP, HEAD = (380.0, 262.0), 36.0, 26.0  # [units of the drawing] width and height, between, above
LETTER, LABEL = 9.0, 23.0  # [units of the drawing] of a label: a letter's width, its height


@dataclass(frozen=True)
class Window:
    """A part of the picture and where it is drawn: ``drawn = origin + scale * (pixel - corner)``."""

    corner: Pixel
    scale: float
    origin: Pixel

    def place(self, pixel: Pixel) -> Pixel:
        """Where a pixel is drawn."""
        x, y = (o + self.scale * (p - c) for o, p, c in zip(self.origin, pixel, self.corner, strict=True))
        return (x, y)


@dataclass(frozen=True)
class DrawingWords:
    """How a drawing speaks: ``texts`` for who leads the session; with ``names``, in lay words and without ids."""

    texts: PageTexts = ENGLISH
    names: LayNames | None = None

    def label(self, role: Role, object_id: str, played: str) -> str:
        """On an object, which plays the part of the source object ``played``, "" for none."""
        if self.names is not None:
            return self.names.of(role, object_id).label
        return self.texts("as_source", target=object_id, source=played) if played else object_id

    def title(self, role: Role, thing: SceneObject) -> str:
        """Of an object, when a pointer rests on it."""
        if self.names is not None:
            return self.names.of(role, thing.object_id).label
        return f"{thing.object_id}: {described_in(thing, self.texts).label}"

    def pair(self, source: str, target: str) -> str:
        """A pair, for who does not see the arrows."""
        if self.names is not None:
            source = self.names.of(Role.SOURCE, source).label
            target = self.names.of(Role.TARGET, target).label
        return self.texts("pair", source=source, target=target)

    def heading(self, role: Role) -> tuple[str, str]:
        """Above a picture, and the smaller words beside it."""
        if self.names is not None:
            return self.texts(f"things_{role}"), ""
        return self.texts(f"{role}_title"), self.texts(f"{role}_sub")


FOR_OPERATOR = DrawingWords()


def mapping_drawing(state: ConsoleState, pictures: Mapping[Role, str], words: DrawingWords = FOR_OPERATOR) -> str:
    """SVG of source and target picture with an arrow for each pair; a scene not seen yet is an empty frame.

    Args:
        state: what is known.
        pictures: address of each scene's picture, "" or missing where there is none: the objects are filled then.
        words: how it speaks.
    """
    left = {Role.SOURCE: 0.0, Role.TARGET: PANEL[0] + GAP}
    scenes = {Role.SOURCE: state.source, Role.TARGET: state.target}
    found = {role: outlines(state.view, s.objects) if state.view and s else () for role, s in scenes.items()}
    windows = _windows(found, left)
    panels = "".join(
        _frame(left[role], words.heading(role), _why_empty(scenes[role], state.view, windows.get(role), words.texts))
        + (_picture(role, state.view, windows[role], found[role], pictures.get(role, "")) if role in windows else "")
        for role in Role
    )
    pairs = _pairs(state)
    arrows = _arrows(pairs, windows, found)
    labels = "".join(_labels(role, windows.get(role), found[role], pairs, words) for role in Role)
    width, height = 2 * PANEL[0] + GAP, HEAD + PANEL[1]
    shapes = "".join(
        [_head("assisted", ASSISTED), _head("inferred", INFERRED), *(_clip(role, x) for role, x in left.items())]
    )
    told = ", ".join(words.pair(source, target) for source, (target, _) in pairs.items()) or words.texts("nothing_yet")
    label = safe(words.texts("mapping_label", pairs=told))
    return (
        f'<svg class="mapping" role="img" aria-label="{label}" viewBox="0 0 {width:g} {height:g}"><defs>{shapes}</defs>'
        f"{panels}{arrows}{labels}</svg>"
    )


def _pairs(state: ConsoleState) -> dict[str, tuple[str, bool]]:
    """Source id -> (target id, assisted by the teacher)."""
    pairs = {s: (t, False) for s, t in state.estimate.executed.pairs} if state.estimate else {}
    if state.session:
        pairs |= {a.source_id: (a.target_id, True) for a in state.session.assists}
    return pairs if state.target else {}


def _windows(found: Mapping[Role, tuple[ObjectOutline, ...]], left: Mapping[Role, float]) -> dict[Role, Window]:
    """Windows onto the objects of both scenes in one scale, so that sizes can be compared by eye."""
    spans = {}
    for role, seen in found.items():
        corners = [c for o in seen for c in o.corners]
        if corners:
            (low_u, low_v), (high_u, high_v) = (tuple(f(c[k] for c in corners) for k in (0, 1)) for f in (min, max))
            spans[role] = (low_u, low_v, high_u, high_v)
    if not spans:
        return {}
    margin = 34.0  # room for labels
    scale = min(
        min(PANEL[0] / (s[2] - s[0] + 2 * margin), PANEL[1] / (s[3] - s[1] + 2 * margin)) for s in spans.values()
    )
    windows = {}
    for role, s in spans.items():
        middle = ((s[0] + s[2]) / 2, (s[1] + s[3]) / 2 + 8)
        corner = (middle[0] - PANEL[0] / 2 / scale, middle[1] - PANEL[1] / 2 / scale)
        windows[role] = Window(corner, scale, (left[role], HEAD))
    return windows


def _clip(role: Role, left: float) -> str:
    return (
        f'<clipPath id="clip-{role}"><rect x="{left:g}" y="{HEAD:g}" width="{PANEL[0]:g}" '
        f'height="{PANEL[1]:g}" rx="8"/></clipPath>'
    )


def _head(name: str, color: str) -> str:
    return (
        f'<marker id="head-{name}" viewBox="-1 -1 13 12" refX="7" refY="5" markerWidth="6" markerHeight="6" '
        f'orient="auto"><path class="head" d="M0 0 L10 5 L0 10 L2.5 5 z" style="fill:{color}"/></marker>'
    )


def _why_empty(scene: Scene | None, view: CameraView | None, window: Window | None, texts: PageTexts) -> str:
    if window is not None:
        return ""
    return texts("not_seen" if scene is None else "no_camera" if view is None else "no_objects")


def _frame(left: float, heading: tuple[str, str], why_empty: str) -> str:
    (width, height), (title, sub) = PANEL, heading
    return (
        f'<text class="title" x="{left:g}" y="17">{safe(title)} <tspan class="sub" dx="4">{safe(sub)}</tspan></text>'
        f'<rect class="frame" x="{left:g}" y="{HEAD:g}" width="{width:g}" height="{height:g}" rx="8"/>'
        f'<text class="empty" x="{left + width / 2:g}" y="{HEAD + height / 2:g}">{safe(why_empty)}</text>'
    )


def _picture(role: Role, view: CameraView | None, window: Window, seen: tuple[ObjectOutline, ...], address: str) -> str:
    parts = [f'<g clip-path="url(#clip-{role})">']
    if address and view is not None:
        x, y = window.place((0.0, 0.0))
        width, height = (window.scale * s for s in view.size)
        parts.append(
            f'<image href="{safe(address)}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
            'preserveAspectRatio="none"/>'
        )
    for outline in seen:
        points = " ".join("{:.1f},{:.1f}".format(*window.place(c)) for c in outline.corners)
        fill = "none" if address else color_of(outline.thing)
        parts.append(
            f'<polygon class="halo" points="{points}"/><polygon class="line" points="{points}" fill="{fill}"/>'
        )
    return "".join([*parts, "</g>"])


def _arrows(
    pairs: Mapping[str, tuple[str, bool]],
    windows: Mapping[Role, Window],
    found: Mapping[Role, tuple[ObjectOutline, ...]],
) -> str:
    if set(windows) != set(Role):
        return ""
    ends = {role: {o.thing.object_id: windows[role].place(o.middle) for o in found[role]} for role in Role}
    parts = []
    for source, (target, assisted) in sorted(pairs.items(), key=lambda pair: pair[1][1]):
        if source not in ends[Role.SOURCE] or target not in ends[Role.TARGET]:
            continue
        (x, y), (to_x, to_y) = ends[Role.SOURCE][source], ends[Role.TARGET][target]
        bow = 0.10 * (to_x - x)
        path = f"M{x:.1f} {y:.1f} Q{(x + to_x) / 2:.1f} {(y + to_y) / 2 - bow:.1f} {to_x:.1f} {to_y:.1f}"
        name, color = ("assisted", ASSISTED) if assisted else ("inferred", INFERRED)
        parts.append(
            f'<g class="arrow {name}" data-pair="{safe(source)}>{safe(target)}"><path class="under" d="{path}"/>'
            f'<path d="{path}" stroke="{color}" stroke-dasharray="{"" if assisted else "9 5"}" '
            f'marker-end="url(#head-{name})"/>'
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{color}"/></g>'
        )
    return "".join(parts)


def _labels(
    role: Role,
    window: Window | None,
    seen: tuple[ObjectOutline, ...],
    pairs: Mapping[str, tuple[str, bool]],
    words: DrawingWords,
) -> str:
    if window is None:
        return ""
    plays = {target: (source, assisted) for source, (target, assisted) in pairs.items()}
    parts = []
    rows: list[tuple[float, float]] = []  # (right end, y) of the labels there are
    for outline in sorted(seen, key=lambda o: o.middle[0]):
        name = outline.thing.object_id
        source, assisted = (
            plays.get(name, ("", False)) if role is Role.TARGET else ("", pairs.get(name, ("", False))[1])
        )
        text = words.label(role, name, source)
        related = bool(source) or (role is Role.SOURCE and name in pairs)
        color = (ASSISTED if assisted else INFERRED) if related else "transparent"
        x, y = window.place(outline.bottom)
        width = LETTER * len(text) + 12
        left = min(max(x - width / 2, window.origin[0]), window.origin[0] + PANEL[0] - width)
        y = _free_row(min(y, window.origin[1] + PANEL[1] - LABEL - 2), left, rows, window.origin[1])
        rows.append((left + width, y))
        parts.append(
            f'<g class="tag"><title>{safe(words.title(role, outline.thing))}</title>'
            f'<rect x="{left:.1f}" y="{y + 2:.1f}" width="{width:.1f}" height="22" rx="5" stroke="{color}"/>'
            f'<text x="{left + width / 2:.1f}" y="{y + 17.5:.1f}">{safe(text)}</text></g>'
        )
    return "".join(parts)


def _free_row(wished: float, left: float, rows: list[tuple[float, float]], top: float) -> float:
    """Where a label that begins at ``left`` covers no other: nearest to where it is wished, and within the picture.

    Args:
        wished: y of it [px of the drawing].
        left: x of its beginning.
        rows: (right end, y) of the labels there are, from left to right.
        top: of the picture.
    """
    near = [at for right, at in rows if left < right + 2]
    places = [wished, *(at + side * LABEL for at in near for side in (-1, 1))]
    inside = [y for y in places if top <= y <= top + PANEL[1] - LABEL - 2 + 1e-9]
    free = [y for y in inside if all(abs(y - at) >= LABEL - 1e-9 for at in near)]
    return min(free, key=lambda y: abs(y - wished), default=wished)
