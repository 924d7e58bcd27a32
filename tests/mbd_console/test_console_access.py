"""The console is this machine's only, or of those who signed in; what it answers no page of another can use."""

from __future__ import annotations

import asyncio
import re
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console.access.gate import AccessGate
from mbd_console.access.headers import SecurityHeaders
from mbd_console.access.rule import COOKIE, AccessRule, AccessVerdict, access_rule, verdict
from mbd_console.access.sign_in import ConsoleRole, SignIns
from mbd_model.errors import MbdError

TOKEN, OBSERVER = "verysecret1", "looksecret2"
HERE, OPEN = access_rule("", ""), access_rule("", TOKEN, OBSERVER)


def nobody(rule: AccessRule = OPEN) -> SignIns:
    return SignIns(rule.token, rule.observer_token, lambda: 0.0)


def test_without_a_token_it_listens_on_this_machine_only():
    assert AccessRule("127.0.0.1", "") == HERE
    assert AccessRule("0.0.0.0", TOKEN, OBSERVER) == OPEN


@pytest.mark.parametrize(
    ("host", "token", "observer"),
    [
        ("0.0.0.0", "", ""), ("192.168.1.4", "", ""), ("::", "", ""), ("", "short", ""), ("", "with space in it", ""),
        ("", "", OBSERVER), ("", TOKEN, TOKEN), ("", TOKEN, "short"),
    ],
)  # fmt: skip
def test_what_would_let_others_in_is_no_rule(host: str, token: str, observer: str):
    with pytest.raises(MbdError):
        access_rule(host, token, observer)


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "localhost"])
def test_this_machine_may_come_in_without_a_token(host: str):
    assert verdict(HERE, nobody(HERE), "/", {"host": host, "origin": f"http://{host}"}) is AccessVerdict.PASS


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "", "[::1", "localhost@evil.example"])
def test_a_foreign_name_that_points_here_may_not(host: str):
    assert verdict(HERE, nobody(HERE), "/", {"host": host}) is AccessVerdict.REFUSE


@pytest.mark.parametrize("rule", [HERE, OPEN])
@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:9999", ""])
def test_a_page_of_another_origin_may_not_act_even_with_the_operators_cookie(rule: AccessRule, origin: str):
    signed = SignIns(TOKEN, "", lambda: 0.0)
    cookie = signed.sign_in(TOKEN, "here")
    headers = {"host": "localhost:8080", "origin": origin, "cookie": f"{COOKIE}={cookie}"}
    assert verdict(rule, signed, "/", headers) is AccessVerdict.REFUSE


@given(given_token=st.text(max_size=20), cookie=st.text(max_size=40))
def test_nothing_but_a_token_opens(given_token: str, cookie: str):
    signed = nobody()
    if given_token not in (TOKEN, OBSERVER):
        assert signed.sign_in(given_token, "there") is None
    assert verdict(OPEN, signed, "/", {"host": "localhost", "cookie": f"{COOKIE}={cookie}"}) is not AccessVerdict.PASS


def test_an_address_opens_nothing():
    sent = through(AccessGate, OPEN, query=b"token=" + TOKEN.encode())
    assert sent[0]["status"] == 401


@given(path=st.sampled_from(["/", "/steps", "/sign_in", "/moment/3", "/observe", "/picture/live", "/_nicegui_ws/x"]))
def test_an_observer_sees_the_participants_view_and_nothing_that_acts(path: str):
    signed = nobody()
    cookie = signed.sign_in(OBSERVER, "there")
    seen = verdict(OPEN, signed, path, {"host": "lab", "cookie": f"{COOKIE}={cookie}"}) is AccessVerdict.PASS
    assert seen == path.startswith(("/observe", "/picture/", "/_nicegui"))


def test_who_gives_wrong_tokens_has_to_wait_and_others_do_not():
    now = 0.0
    signed = SignIns(TOKEN, "", lambda: now)
    for _ in range(5):
        assert not signed.must_wait("there")
        assert signed.sign_in("wrong", "there") is None
    assert signed.must_wait("there")
    assert not signed.must_wait("here")
    now = 61.0
    assert not signed.must_wait("there")


def test_a_cookie_is_good_for_a_day_of_sessions_and_not_for_ever():
    now = 0.0
    signed = SignIns(TOKEN, "", lambda: now)
    cookie = signed.sign_in(TOKEN, "here")
    assert cookie is not None
    assert TOKEN not in cookie
    assert signed.role(cookie) is ConsoleRole.OPERATOR
    now = 13 * 3600.0
    assert signed.role(cookie) is None


def test_every_sign_in_gives_another_cookie_that_nobody_guesses():
    signed = SignIns(TOKEN, "", lambda: 0.0)
    cookies = [signed.sign_in(TOKEN, "here") or "" for _ in range(100)]
    assert len(set(cookies)) == 100
    # 256 random bits are 43 signs of base 64; no sign stands at its place in all of them.
    assert {len(cookie) for cookie in cookies} == {43}
    assert min(len({cookie[place] for cookie in cookies}) for place in range(42)) > 10


def through(
    middleware: Any, *words: Any, kind: str = "http", query: bytes = b"", form: bytes | None = None, page: bytes = b""
) -> list[dict[str, Any]]:
    """What is sent when a request goes through a middleware to a page."""
    sent: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": [(b"content-type", b"text/html")]})
        await send({"type": "http.response.body", "body": page[:9], "more_body": True})
        await send({"type": "http.response.body", "body": page[9:]})

    async def receive() -> Any:
        return {"type": "http.request", "body": form}

    async def send(message: Any) -> None:
        sent.append(message)

    scope = {
        "type": kind,
        "headers": [(b"host", b"lab:8080")],
        "query_string": query,
        "path": "/" if form is None else "/sign_in",
        "method": "GET" if form is None else "POST",
        "client": ("there", 1),
    }
    asyncio.run(middleware(app, *words)(scope, receive, send))
    return sent


def test_a_refused_websocket_is_closed_and_a_page_asks_for_the_token():
    assert through(AccessGate, OPEN, kind="websocket")[0]["type"] == "websocket.close"
    start, body = through(AccessGate, OPEN)
    assert start["status"] == 401
    assert b'method="post"' in body["body"]


def test_the_form_sets_a_cookie_that_scripts_cannot_read_and_that_is_not_the_token():
    start, _ = through(AccessGate, OPEN, form=b"token=" + TOKEN.encode())
    headers = dict(start["headers"])
    assert (start["status"], headers[b"location"]) == (303, b"/")
    assert TOKEN.encode() not in headers[b"set-cookie"]
    assert b"HttpOnly" in headers[b"set-cookie"]
    assert b"SameSite=Strict" in headers[b"set-cookie"]
    assert through(AccessGate, OPEN, form=b"token=" + OBSERVER.encode())[0]["headers"][2] == (b"location", b"/observe")
    assert through(AccessGate, OPEN, form=b"token=wrong")[0]["status"] == 401


def test_no_page_may_frame_the_console_and_only_its_own_scripts_run():
    page = b"<html><script>one()</script><script src=x></script><p>scripts</p></html>"
    start, body = through(SecurityHeaders, page=page)
    headers = dict(start["headers"])
    policy = headers[b"content-security-policy"].decode()
    nonce = re.search(r"'nonce-([0-9a-f]{32})'", policy)
    assert nonce is not None
    assert "frame-ancestors 'none'" in policy
    assert "'unsafe-inline'" not in re.search(r"script-src [^;]*", policy)[0]
    assert body["body"].count(f"<script nonce={nonce[1]}".encode()) == page.count(b"<script") == 2
    assert int(headers[b"content-length"]) == len(body["body"])
    assert headers[b"x-content-type-options"] == b"nosniff"
    assert headers[b"referrer-policy"] == b"no-referrer"
    again = dict(through(SecurityHeaders, page=page)[0]["headers"])
    assert again[b"content-security-policy"] != headers[b"content-security-policy"]
