"""The table of keys that `?` opens."""

from __future__ import annotations

from mbd_console.actions import ACTIONS, Action
from mbd_console.palette import safe
from mbd_console.study.markers import MARKERS
from mbd_console.words.texts import PageTexts


def keys_dialog(texts: PageTexts, stop_key: str) -> str:
    """A dialog of the browser's own, so that Escape closes it and the focus stays in it."""
    rows = [(stop_key, texts("tip_stop_robot"))]
    for action, spec in ACTIONS.items():
        twice = f" - {texts('twice')}" if spec.confirm else ""
        label = "" if action is Action.NOTE else f"{spec.label(texts)}: "
        rows.append((spec.key_label, f"{label}{spec.hint(texts)}{twice}"))
    rows += [("1-9", texts("tip_object"))]
    rows += [(key.upper(), f"{texts('markers')}: {texts(f'marker_{name}')}") for key, name in MARKERS.items()]
    rows += [("V", texts("tip_study")), ("Esc", texts("tip_escape")), ("?", texts("tip_help"))]
    table = "".join(f'<tr><th scope="row"><kbd>{safe(k)}</kbd></th><td>{safe(what)}</td></tr>' for k, what in rows)
    return (
        f'<dialog id="keys" aria-labelledby="keys-title"><h2 id="keys-title">{safe(texts("keys_title"))}</h2>'
        f'<div class="keys-table" tabindex="0" role="group" aria-labelledby="keys-title"><table>{table}</table></div>'
        f'<button type="button" data-toggle="keys">{safe(texts("keys_close"))}</button></dialog>'
    )
