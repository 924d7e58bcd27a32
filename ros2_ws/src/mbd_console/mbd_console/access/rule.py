"""Who may open the console: this machine only, or whoever signed in with a token."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

from mbd_model.errors import MbdError

from mbd_console.access.sign_in import ConsoleRole, SignIns

COOKIE = "mbd_console"
SHORTEST_TOKEN = 8
LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
# All an observer may have: the participant's page, what it shows, and what NiceGUI needs to show it.
_OBSERVED = ("/observe", "/picture/", "/_nicegui")


@dataclass(frozen=True)
class AccessRule:
    """Where the console listens and whom it lets in.

    Attributes:
        host: address it binds.
        token: with which an operator signs in; "" for none.
        observer_token: with which somebody signs in who may look and do nothing; "" for none.
    """

    host: str
    token: str
    observer_token: str = ""


def access_rule(host: str, token: str, observer_token: str = "") -> AccessRule:
    """The rule from what the operator gave: "" as host means this machine only, or every address with a token.

    Raises:
        MbdError: other machines could get in without a token, or a token is too short to keep them out.
    """
    for name, given in (("token", token), ("observer token", observer_token)):
        if given and len(given) < SHORTEST_TOKEN:
            raise MbdError(
                f"the {name} has {len(given)} characters; give at least {SHORTEST_TOKEN} that nobody guesses"
            )
        if given and not (given.isascii() and given.isprintable() and " " not in given):
            raise MbdError(f"the {name} may hold letters, digits and signs of ASCII only, no space; choose another")
    if observer_token and not token:
        raise MbdError("an observer token without a token would let observers in and no operator: give --token too")
    if token and token == observer_token:
        raise MbdError("token and observer token are the same, so that observers could act; choose two")
    chosen = host or ("0.0.0.0" if token else "127.0.0.1")
    if chosen not in LOOPBACK and not token:
        raise MbdError(f"host {chosen} would open the console to the network without a token: give --token too")
    return AccessRule(chosen, token, observer_token)


class AccessVerdict(Enum):
    """What becomes of a request."""

    PASS = "pass"
    SIGN_IN = "sign in"
    REFUSE = "refuse"


def verdict(rule: AccessRule, signed_in: SignIns, path: str, headers: Mapping[str, str]) -> AccessVerdict:
    """Whether a request may pass.

    A page of another origin that the operator's browser has open must not be able to act in the operator's name: the
    Origin, when there is one, must be the host asked for; and without a token that host must be this machine itself,
    so that no foreign name can be made to point here.

    Args:
        rule: whom to let in.
        signed_in: who signed in.
        path: asked for.
        headers: of the request, names in lower case.
    """
    host = headers.get("host", "")
    origin = headers.get("origin")
    if origin is not None and urlsplit(origin).netloc != host:
        return AccessVerdict.REFUSE
    if not rule.token:
        return AccessVerdict.PASS if _hostname(host) in LOOPBACK else AccessVerdict.REFUSE
    role = signed_in.role(cookie_value(headers.get("cookie", "")))
    if role is None:
        return AccessVerdict.SIGN_IN
    return AccessVerdict.PASS if role is ConsoleRole.OPERATOR or path.startswith(_OBSERVED) else AccessVerdict.REFUSE


def _hostname(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def cookie_value(header: str) -> str:
    """The console's cookie in a Cookie header; "" when it has none."""
    try:
        found = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return found.value if found else ""
