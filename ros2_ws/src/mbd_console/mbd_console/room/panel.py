"""The operator's switch for the room, its test signal and its picture, as HTML; static/room.js gives them life."""

from __future__ import annotations

import json

from mbd_model.room import chirp

from mbd_console.palette import safe
from mbd_console.words.texts import PageTexts

# What the page's script says by itself.
SAID = (
    "room_insecure",
    "room_no_device",
    "room_no_webm",
    "room_gone",
    "room_opening",
    "room_runs",
    "room_kept",
    "room_signalled",
    "room_sound_only",
    "room_picture_only",
    "room_lost",
)


def room_panel(texts: PageTexts) -> str:
    """The part of the study tools that is about the room; the script writes into its line of status."""
    words = json.dumps({name: texts(name) for name in SAID}, ensure_ascii=False)
    sounds = {"low": chirp.LOW, "high": chirp.HIGH, "seconds": chirp.SECONDS, "edge": chirp.EDGE}
    signal = json.dumps({**sounds, "after": chirp.BY_AIR_AFTER})
    return (
        f'<section id="room" aria-labelledby="room-title" data-language="{texts.language}" data-words="{safe(words)}" '
        f'data-signal="{safe(signal)}"><h2 id="room-title">{safe(texts("room_title"))}</h2>'
        f'<p class="room-consent">{safe(texts("room_consent"))}</p><div class="row">'
        f'<button type="button" id="room-switch" role="switch" aria-checked="false">{safe(texts("room_switch"))}'
        f'</button><button type="button" id="room-signal" disabled>{safe(texts("room_signal"))}</button></div>'
        f'<p id="room-said" role="status" aria-live="polite"></p>'
        f'<video id="room-picture" muted playsinline hidden aria-label="{safe(texts("room_picture"))}"></video>'
        '<div id="room-flash" hidden aria-hidden="true"></div></section>'
    )
