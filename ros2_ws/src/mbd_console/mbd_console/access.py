"""Who may open the console: this machine only, or whoever knows the token."""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from dataclasses import dataclass
from enum import Enum
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

from mbd_model.errors import MbdError

COOKIE = "mbd_console_token"
SHORTEST_TOKEN = 8
LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})


@dataclass(frozen=True)
class AccessRule:
    """Where the console listens and whom it lets in.

    Attributes:
        host: address it binds.
        token: that every request must bring; "" for none.
    """

    host: str
    token: str


def access_rule(host: str, token: str) -> AccessRule:
    """The rule from what the operator gave: "" as host means this machine only, or every address with a token.

    Raises:
        MbdError: other machines could get in without a token, or the token is too short to keep them out.
    """
    if token and len(token) < SHORTEST_TOKEN:
        raise MbdError(f"the token has {len(token)} characters; give at least {SHORTEST_TOKEN} that nobody guesses")
    if token and not (token.isascii() and token.isalnum()):
        raise MbdError("the token may hold letters and digits only, so that it fits into an address; choose another")
    chosen = host or ("0.0.0.0" if token else "127.0.0.1")
    if chosen not in LOOPBACK and not token:
        raise MbdError(f"host {chosen} would open the console to the network without a token: give --token too")
    return AccessRule(chosen, token)


class Verdict(Enum):
    """What becomes of a request."""

    PASS = "pass"
    SET_COOKIE = "set cookie"
    REFUSE = "refuse"


def verdict(rule: AccessRule, query: str, headers: Mapping[str, str]) -> Verdict:
    """Whether a request may pass.

    A page of another origin that the operator's browser has open must not be able to act in the operator's name: the
    Origin, when there is one, must be the host asked for; and without a token that host must be this machine itself,
    so that no foreign name can be made to point here.

    Args:
        rule: whom to let in.
        query: the address's query, without "?".
        headers: of the request, names in lower case.
    """
    host = headers.get("host", "")
    origin = headers.get("origin")
    if origin is not None and urlsplit(origin).netloc != host:
        return Verdict.REFUSE
    if not rule.token:
        return Verdict.PASS if _hostname(host) in LOOPBACK else Verdict.REFUSE
    given = parse_qs(query).get("token", [""])[0]
    if hmac.compare_digest(given.encode(), rule.token.encode()):
        return Verdict.SET_COOKIE
    if hmac.compare_digest(_cookie(headers.get("cookie", "")).encode(), rule.token.encode()):
        return Verdict.PASS
    return Verdict.REFUSE


def _hostname(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _cookie(header: str) -> str:
    try:
        found = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return found.value if found else ""


Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]
REFUSAL = (
    b"This console is closed: open it on the machine it runs on, or with the address that ends in ?token=... "
    b"which its log shows.\n"
)


class AccessGate:
    """ASGI middleware: lets a request, or a websocket, through by ``verdict``."""

    def __init__(self, app: App, rule: AccessRule) -> None:
        self._app, self._rule = app, rule

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on, pass on with the cookie set, or refuse."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        decided = verdict(self._rule, scope.get("query_string", b"").decode("latin-1"), headers)
        if decided is Verdict.PASS or (decided is Verdict.SET_COOKIE and scope["type"] == "websocket"):
            await self._app(scope, receive, send)
        elif decided is Verdict.SET_COOKIE:
            await self._app(scope, receive, self._with_cookie(send))
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            kind = (b"content-type", b"text/plain; charset=utf-8")
            await send({"type": "http.response.start", "status": 403, "headers": [kind]})
            await send({"type": "http.response.body", "body": REFUSAL})

    def _with_cookie(self, send: Send) -> Send:
        cookie = f"{COOKIE}={self._rule.token}; HttpOnly; SameSite=Strict; Path=/".encode()

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", []), (b"set-cookie", cookie)]
            await send(message)

        return sending
