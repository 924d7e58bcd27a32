"""ASGI middleware in front of all pages: it lets in, asks to sign in, or refuses."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import parse_qs

from mbd_console.access.rule import COOKIE, AccessRule, AccessVerdict, verdict
from mbd_console.access.sign_in import ConsoleRole, SignIns

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]
SIGN_IN = "/sign_in"
_LARGEST_FORM = 4096  # [byte]
_REFUSAL = (
    "This is not open to you: the console is for the machine it runs on, or for who signed in with its token; "
    "an observer sees /observe only.\n"
)
_FORM = """<!doctype html><html lang="en"><title>Sign in</title><meta name="viewport" content="width=device-width">
<body><h1>Mapping by demonstration</h1><form method="post" action="/sign_in"><p>{words}</p>
<p><label>Token <input name="token" type="password" autocomplete="current-password" autofocus required></label>
<button>Sign in</button></p></form></body></html>
"""


class AccessGate:
    """Lets a request, or a websocket, through by ``verdict``.

    Args:
        app: behind it.
        rule: whom to let in.
        clock: time now [s], steady.
    """

    def __init__(self, app: App, rule: AccessRule, clock: Callable[[], float] = time.monotonic) -> None:
        self._app, self._rule = app, rule
        self._signed_in = SignIns(rule.token, rule.observer_token, clock)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on, show the form, take it, or refuse."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        decided = verdict(self._rule, self._signed_in, scope.get("path", "/"), headers)
        if decided is AccessVerdict.PASS:
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        elif decided is AccessVerdict.REFUSE:
            await _answer(send, 403, _REFUSAL)
        elif scope.get("path") == SIGN_IN and scope.get("method") == "POST":
            await self._take_form(scope, receive, send)
        else:
            await _answer(send, 401, _FORM.format(words="Give the console’s token."), html=True)

    async def _take_form(self, scope: Scope, receive: Receive, send: Send) -> None:
        address = str((scope.get("client") or ("",))[0])
        if self._signed_in.must_wait(address):
            await _answer(send, 429, "Too many wrong tokens: wait a minute, then try again.\n")
            return
        body = await _body(receive)
        given = parse_qs(body.decode("latin-1")).get("token", [""])[0]
        cookie = self._signed_in.sign_in(given, address)
        if cookie is None:
            await _answer(send, 401, _FORM.format(words="That is not the token; try again."), html=True)
            return
        page = "/" if self._signed_in.role(cookie) is ConsoleRole.OPERATOR else "/observe"
        kept = f"{COOKIE}={cookie}; HttpOnly; SameSite=Strict; Path=/"
        await _answer(send, 303, "", {"location": page, "set-cookie": kept})


async def _body(receive: Receive) -> bytes:
    """The body of a request, of one that is too large its beginning."""
    body, more = b"", True
    while more and len(body) <= _LARGEST_FORM:
        message = await receive()
        body += message.get("body", b"")
        more = bool(message.get("more_body", False)) and message["type"] == "http.request"
    return body[:_LARGEST_FORM]


async def _answer(
    send: Send, status: int, text: str, headers: dict[str, str] | None = None, *, html: bool = False
) -> None:
    kind = "text/html" if html else "text/plain"
    all_headers = {"content-type": f"{kind}; charset=utf-8", "cache-control": "no-store", **(headers or {})}
    encoded = [(k.encode(), v.encode()) for k, v in all_headers.items()]
    await send({"type": "http.response.start", "status": status, "headers": encoded})
    await send({"type": "http.response.body", "body": text.encode()})
