"""The console is this machine's only, or of those who know the token."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console.access import COOKIE, AccessGate, AccessRule, Verdict, access_rule, verdict
from mbd_model.errors import MbdError

TOKEN = "verysecret1"
HERE, OPEN = access_rule("", ""), access_rule("", TOKEN)


def test_without_a_token_it_listens_on_this_machine_only():
    assert AccessRule("127.0.0.1", "") == HERE
    assert AccessRule("0.0.0.0", TOKEN) == OPEN


@pytest.mark.parametrize(
    ("host", "token"), [("0.0.0.0", ""), ("192.168.1.4", ""), ("::", ""), ("", "short"), ("", "with space in it")]
)
def test_what_would_let_others_in_is_no_rule(host: str, token: str):
    with pytest.raises(MbdError):
        access_rule(host, token)


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "localhost"])
def test_this_machine_may_come_in_without_a_token(host: str):
    assert verdict(HERE, "", {"host": host, "origin": f"http://{host}"}) is Verdict.PASS


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "", "[::1", "localhost@evil.example"])
def test_a_foreign_name_that_points_here_may_not(host: str):
    assert verdict(HERE, "", {"host": host}) is Verdict.REFUSE


@pytest.mark.parametrize("rule", [HERE, OPEN])
@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:9999", ""])
def test_a_page_of_another_origin_may_not_act_even_with_the_operators_cookie(rule: AccessRule, origin: str):
    headers = {"host": "localhost:8080", "origin": origin, "cookie": f"{COOKIE}={TOKEN}"}
    assert verdict(rule, "", headers) is Verdict.REFUSE


def test_the_token_opens_by_address_and_from_then_on_by_cookie():
    assert verdict(OPEN, f"token={TOKEN}", {"host": "lab:8080"}) is Verdict.SET_COOKIE
    assert verdict(OPEN, "", {"host": "lab:8080", "cookie": f"a=b; {COOKIE}={TOKEN}"}) is Verdict.PASS


@given(given_token=st.text(max_size=20), cookie=st.text(max_size=40))
def test_nothing_else_opens(given_token: str, cookie: str):
    if TOKEN not in given_token + cookie:
        assert verdict(OPEN, f"token={given_token}", {"host": "localhost", "cookie": cookie}) is Verdict.REFUSE


def through_gate(rule: AccessRule, kind: str, query: bytes = b"") -> tuple[bool, list[dict[str, Any]]]:
    """Whether the app behind the gate was reached, and what was sent."""
    reached, sent = [], []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        reached.append(scope)
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def send(message: Any) -> None:
        sent.append(message)

    scope = {"type": kind, "headers": [(b"host", b"lab:8080")], "query_string": query}
    asyncio.run(AccessGate(app, rule)(scope, None, send))
    return bool(reached), sent


def test_a_refused_websocket_is_closed_and_a_refused_page_states_what_to_do():
    reached, sent = through_gate(OPEN, "websocket")
    assert not reached
    assert sent[0]["type"] == "websocket.close"
    reached, sent = through_gate(OPEN, "http")
    assert not reached
    assert sent[0]["status"] == 403
    assert b"token" in sent[1]["body"]


def test_the_cookie_is_set_once_the_token_was_given_and_scripts_cannot_read_it():
    reached, sent = through_gate(OPEN, "http", f"token={TOKEN}".encode())
    assert reached
    cookie = dict(sent[0]["headers"])[b"set-cookie"]
    assert cookie.startswith(f"{COOKIE}={TOKEN};".encode())
    assert b"HttpOnly" in cookie and b"SameSite=Strict" in cookie
