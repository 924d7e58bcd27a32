"""The addresses by which an operator's page sends sound and picture of the room. The gate lets operators only in."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse
from mbd_model.errors import MbdError
from mbd_model.room.recording import LARGEST_FILE, SIGNAL_MARKER, room_recording, signal_words

from mbd_console.requests import WriteNote
from mbd_console.room.refusal import RoomRefusedError
from mbd_console.room.store import LARGEST_CHUNK, RoomStore
from mbd_console.words.texts import texts_in

_FRESH = {"Cache-Control": "no-store"}
_SMALL = 1024  # [byte] of what a page says before it begins
_NEAR = 60.0  # [s] between now and when a signal sounded that is marked in the bag


def room_routes(
    store: RoomStore,
    now: Callable[[], float],
    send: Callable[[WriteNote], None],
    records: Callable[[], bool],
) -> APIRouter:
    """``/room/clock``, ``/room/begin``, ``/room/<film>/<chunk>`` and ``/room/<film>``.

    Args:
        store: of the films.
        now: the session's clock [s].
        send: publishes a note, which marks a test signal in the bag.
        records: whether a recorder runs, beside whose bag a film may lie.
    """
    router = APIRouter(prefix="/room")

    def possible() -> None:
        if not records():
            raise RoomRefusedError("room_no_recorder", 409)

    @router.get("/clock")
    async def clock() -> Response:
        return JSONResponse({"session": now()}, headers=_FRESH)

    @router.get("/possible")
    async def ask(lang: str = "") -> Response:
        return await _answered(lang, lambda: _asked(store, possible))

    @router.post("/begin")
    async def begin(request: Request, lang: str = "") -> Response:
        data = await _body(request, _SMALL)

        def begun() -> dict[str, Any]:
            _refuse_other_kind(request, "application/json")
            possible()
            sound, picture = _kinds(data)
            return dict(zip(("name", "key"), store.begin(sound=sound, picture=picture), strict=True))

        return await _answered(lang, begun)

    @router.post("/{name}/{number}")
    async def chunk(request: Request, name: str, number: int, lang: str = "") -> Response:
        data, key = await _body(request, LARGEST_CHUNK), request.headers.get("x-room-key", "")

        def added() -> dict[str, Any]:
            _refuse_other_kind(request, "video/webm")
            return {"size": store.append(name, key, number, data)}

        return await _answered(lang, added)

    @router.post("/{name}")
    async def facts(request: Request, name: str, lang: str = "") -> Response:
        data = await _body(request, LARGEST_FILE)

        def kept() -> dict[str, Any]:
            _refuse_other_kind(request, "application/json")
            return _kept(store, name, data, now, send)

        return await _answered(lang, kept)

    return router


def _asked(store: RoomStore, possible: Callable[[], None]) -> dict[str, Any]:
    refusal = store.why_not()
    if refusal is not None:
        raise refusal
    possible()
    return {}


def _kinds(data: bytes) -> tuple[bool, bool]:
    """Whether a page has sound, and a picture; both, where it does not say."""
    try:
        said = json.loads(data)
    except (ValueError, RecursionError):
        said = {}
    said = said if isinstance(said, dict) else {}
    return said.get("sound") is not False, said.get("picture") is not False


def _kept(
    store: RoomStore, name: str, data: bytes, now: Callable[[], float], send: Callable[[WriteNote], None]
) -> dict[str, Any]:
    try:
        raw = json.loads(data)
        recording = room_recording(raw)
        key = raw.get("key")
    except (ValueError, RecursionError) as error:
        raise RoomRefusedError("room_facts", 422, why=str(error)[:200]) from error
    for signal in store.keep(name, key if isinstance(key, str) else "", recording):
        at = recording.session_time(signal.browser)
        if abs(at - now()) < _NEAR:
            send(WriteNote(signal_words(name, signal.number), SIGNAL_MARKER, at))
        store.mark(name, signal.number)
    return {}


async def _answered(language: str, doing: Callable[[], dict[str, Any]]) -> Response:
    """What came of it, or why it was refused, in the page's language; done off the loop that serves the pages."""
    try:
        return JSONResponse(await run_in_threadpool(doing), headers=_FRESH)
    except RoomRefusedError as refusal:
        why = texts_in(language)(refusal.text, **refusal.values)
        return JSONResponse({"why": why, "text": refusal.text}, refusal.status, headers=_FRESH)
    except MbdError as error:  # nobody listens to the note yet
        return JSONResponse({"why": str(error), "text": ""}, 409, headers=_FRESH)


def _refuse_other_kind(request: Request, kind: str) -> None:
    """A form of another site's page could send other kinds without being asked whether it may."""
    given = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if given != kind:
        raise RoomRefusedError("room_kind", 415, given=given[:40] or "-", kind=kind)


async def _body(request: Request, most: int) -> bytes:
    """The body of a request; of one that is too large one byte more than may be, so that it is refused."""
    body = bytearray()
    async for part in request.stream():
        body += part
        if len(body) > most:
            return bytes(body[: most + 1])
    return bytes(body)
