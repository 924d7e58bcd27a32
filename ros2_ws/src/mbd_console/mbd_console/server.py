"""The web server: the console at /, the steps at /steps, the participant's view at /observe, and their pictures."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from fastapi import Response
from mbd_model.times import to_seconds
from nicegui import app, ui

from mbd_console.access.gate import AccessGate
from mbd_console.access.headers import SecurityHeaders
from mbd_console.access.rule import AccessRule
from mbd_console.desk import Desk
from mbd_console.page import OperatorPage
from mbd_console.participant.page import ParticipantPage
from mbd_console.parts.page_parts import PERIOD, head_of
from mbd_console.pictures import LIVE
from mbd_console.room.routes import room_routes
from mbd_console.steps.moments import no_picture
from mbd_console.steps.page import StepsPage
from mbd_console.words.texts import texts_in

STATIC = Path(__file__).parent / "static"


def serve(desk: Desk, rule: AccessRule, port: int, stopped: Callable[[], bool]) -> None:
    """Serve the pages until SIGINT or SIGTERM. Nothing is fetched from elsewhere.

    Args:
        desk: what the pages show.
        rule: who may open them, and where they are served.
        port: TCP port.
        stopped: True once the process was asked to stop before the web server took over its signals.
    """
    styles = ("scheme.css", "console.css", "steps.css", "study.css")
    head = "".join(f"<style>{(STATIC / name).read_text()}</style>" for name in styles)

    def script(*names: str) -> str:
        return "".join(f"<script>{(STATIC / name).read_text()}</script>" for name in names)

    console_script, observer_script = (
        script("shared.js", "console.js", "room.js"),
        script("shared.js", "participant.js"),
    )

    def console(lang: str = "") -> None:
        texts = texts_in(lang or desk.language)
        ui.add_head_html(head_of(texts, "operator_title") + head + console_script)
        OperatorPage(desk, texts)

    def observe(lang: str = "") -> None:
        texts = texts_in(lang or desk.language)
        ui.add_head_html(head_of(texts, "participant_title") + head + observer_script)
        ParticipantPage(desk, texts)

    def picture(name: str, v: int = 0) -> Response:
        found = desk.pictures.jpeg(name)
        if found is None or (name == LIVE and found[0] == v):
            return Response(status_code=204)
        headers = {"X-Version": str(found[0]), "Cache-Control": "no-store"}
        return Response(found[1], media_type="image/jpeg", headers=headers)

    def moment(at: int, lang: str = "") -> Response:
        data = desk.moments.jpeg(to_seconds(at))
        if data is None:
            shown = no_picture(texts_in(lang or desk.language))
            return Response(shown, media_type="image/svg+xml", headers={"Cache-Control": "no-store"})
        return Response(data, media_type="image/jpeg", headers={"Cache-Control": "no-store"})

    def steps(lang: str = "") -> None:
        texts = texts_in(lang or desk.language)
        ui.add_head_html(head_of(texts, "shown_title") + head + script("shared.js"))
        StepsPage(desk, texts)

    # Light or dark as the browser's user has chosen.
    ui.page("/", dark=None)(console)
    ui.page("/steps", dark=None)(steps)
    app.get("/moment/{at}")(moment)
    ui.page("/observe", dark=None)(observe)
    app.get("/picture/{name}")(picture)
    app.include_router(
        room_routes(desk.room, desk.now, desk.send, lambda: desk.state.recorder.records(time.monotonic()))
    )
    app.add_middleware(AccessGate, rule=rule)
    app.add_middleware(SecurityHeaders)
    app.timer(PERIOD / 2, desk.catch_up)
    app.timer(PERIOD, lambda: app.shutdown() if stopped() else None)
    ui.run(
        host=rule.host,
        port=port,
        show=False,
        reload=False,
        show_welcome_message=False,
        reconnect_timeout=10.0,
        # A page that does not close its connection must not keep the process.
        timeout_graceful_shutdown=1,
    )
