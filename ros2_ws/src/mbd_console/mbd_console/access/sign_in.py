"""Signing in with a token, and how often it may be tried. A token travels once, in the body of a form."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

_TRIES, _WINDOW = 5, 60.0  # wrong tokens that one address may give within so long [s]
_ALL_TRIES = 100  # and all addresses together
_KEPT = 200  # who signed in at once; the oldest signs in again
_SESSION = 12 * 3600.0  # [s] for which a cookie is good


class ConsoleRole(StrEnum):
    """What somebody may do who signed in."""

    OPERATOR = "operator"
    OBSERVER = "observer"


@dataclass
class SignIns:
    """Who signed in. Forgotten when the console ends, so that everybody signs in again.

    Attributes:
        operator, observer: the tokens; "" for none.
        clock: time now [s], steady.
    """

    operator: str
    observer: str
    clock: Callable[[], float]
    _roles: dict[str, tuple[ConsoleRole, float]] = field(default_factory=dict)
    _wrong: list[tuple[float, str]] = field(default_factory=list)

    def role(self, cookie: str) -> ConsoleRole | None:
        """What the bearer of a cookie may do; None for one who did not sign in, or too long ago."""
        role, since = self._roles.get(cookie, (None, 0.0))
        return role if role is not None and self.clock() - since < _SESSION else None

    def must_wait(self, address: str) -> bool:
        """Whether an address gave too many wrong tokens lately, or all did together."""
        now = self.clock()
        self._wrong = [(at, who) for at, who in self._wrong if now - at < _WINDOW]
        return len(self._wrong) >= _ALL_TRIES or sum(who == address for _, who in self._wrong) >= _TRIES

    def sign_in(self, token: str, address: str) -> str | None:
        """A new cookie for whoever gives a right token; None for a wrong one, which is counted.

        Args:
            token: given.
            address: from which it came.
        """
        for right, role in ((self.operator, ConsoleRole.OPERATOR), (self.observer, ConsoleRole.OBSERVER)):
            if right and hmac.compare_digest(token.encode(), right.encode()):
                cookie = secrets.token_urlsafe(32)
                self._roles[cookie] = role, self.clock()
                while len(self._roles) > _KEPT:
                    del self._roles[next(iter(self._roles))]
                return cookie
        self._wrong.append((self.clock(), address))
        return None
