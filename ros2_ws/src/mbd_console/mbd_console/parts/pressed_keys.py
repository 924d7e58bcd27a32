"""What a key pressed on the operator's page stands for."""

from __future__ import annotations

from mbd_console.actions import KEYS, OBJECT_KEYS
from mbd_console.study.markers import MARKERS


def action_of_key(raw: object) -> object:
    """A key pressed, as the action it stands for; None for a key that stands for nothing."""
    if not isinstance(raw, dict) or raw.get("action") != "key":
        return raw
    key = raw.get("key")
    if isinstance(key, str) and key in KEYS:
        return {**raw, "action": KEYS[key]}
    if isinstance(key, str) and key in MARKERS:
        return {"do": "marker", "name": MARKERS[key]}
    if isinstance(key, str) and len(key) == 1 and key in OBJECT_KEYS:
        return {**raw, "action": "object", "number": key}
    return {"action": "escape"} if key == "Escape" else None
