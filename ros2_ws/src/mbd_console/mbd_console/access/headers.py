"""What a browser may do with the console's pages, told in headers of every answer.

No page may frame them, no script runs but those of the console's own pages (by a nonce that is new for each answer)
and files; camera and microphone may be asked for by the operator's page alone; where one came from is told nobody. Vue,
below NiceGUI, compiles its templates in the browser, which needs ``unsafe-eval``; it takes no text of ours for code.
"""

from __future__ import annotations

import re
import secrets
from typing import Any

from mbd_console.access.gate import App, Message, Receive, Scope, Send

_POLICY = (
    "default-src 'self'; script-src 'self' 'nonce-{nonce}' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' ws: wss:; object-src 'none'; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_HEADERS = {
    "x-frame-options": "DENY",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}
_PERMITTED = "camera={eyes}, microphone={eyes}, geolocation=()"
_OF_OPERATOR = "/"  # the one page that may ask for camera and microphone, for sound and picture of the room
# Of pages only, and not of the texts in them: there "<" is written "&lt;".
_SCRIPT = re.compile(rb"<script(?=[\s>])")


class SecurityHeaders:
    """ASGI middleware, outermost: adds the headers, and the nonce to the scripts of a page.

    Args:
        app: behind it.
    """

    def __init__(self, app: App) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on, and add to the answer."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        nonce = secrets.token_hex(16)
        started: list[Message] = []
        body = bytearray()
        # A page must not be compressed before its scripts are marked.
        asked = [(k, v) for k, v in scope["headers"] if k.lower() != b"accept-encoding"]
        plain = {**scope, "headers": asked} if not scope.get("path", "").startswith("/_nicegui") else scope

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = _with_headers(message.get("headers", []), nonce, scope.get("path", ""))
                if _is_page(message["headers"]):
                    started.append(message)
                    return
            elif started and message["type"] == "http.response.body":
                body.extend(message.get("body", b""))
                if message.get("more_body", False):
                    return
                marked = _SCRIPT.sub(b"<script nonce=" + nonce.encode(), bytes(body))
                await send(_with_length(started[0], len(marked)))
                message = {"type": "http.response.body", "body": marked}
            await send(message)

        await self._app(plain, receive, sending)


def _with_headers(headers: Any, nonce: str, path: str) -> list[tuple[bytes, bytes]]:
    permitted = _PERMITTED.format(eyes="(self)" if path == _OF_OPERATOR else "()")
    added = {**_HEADERS, "permissions-policy": permitted, "content-security-policy": _POLICY.format(nonce=nonce)}
    kept = [(bytes(k), bytes(v)) for k, v in headers if bytes(k).lower().decode("latin-1") not in added]
    return kept + [(k.encode(), v.encode()) for k, v in added.items()]


def _is_page(headers: list[tuple[bytes, bytes]]) -> bool:
    found = {k.lower(): v for k, v in headers}
    return found.get(b"content-type", b"").startswith(b"text/html") and b"content-encoding" not in found


def _with_length(start: Message, length: int) -> Message:
    headers = [(k, v) for k, v in start["headers"] if k.lower() != b"content-length"]
    return {**start, "headers": [*headers, (b"content-length", str(length).encode())]}
