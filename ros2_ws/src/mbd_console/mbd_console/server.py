"""The web server: the console at /, the steps at /steps, the participant's view at /observe, and their pictures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fastapi import Response
from mbd_model.times import to_seconds
from nicegui import app, ui

from mbd_console.access.gate import AccessGate
from mbd_console.access.headers import SecurityHeaders
from mbd_console.access.rule import AccessRule
from mbd_console.desk import Desk
from mbd_console.page import PERIOD, OperatorPage, observer_page
from mbd_console.pictures import LIVE
from mbd_console.steps.moments import NO_PICTURE
from mbd_console.steps.page import StepsPage

STATIC = Path(__file__).parent / "static"


def serve(desk: Desk, rule: AccessRule, port: int, stopped: Callable[[], bool]) -> None:
    """Serve the pages until SIGINT or SIGTERM. Nothing is fetched from elsewhere.

    Args:
        desk: what the pages show.
        rule: who may open them, and where they are served.
        port: TCP port.
        stopped: True once the process was asked to stop before the web server took over its signals.
    """
    head = "".join(f"<style>{(STATIC / name).read_text()}</style>" for name in ("console.css", "steps.css"))
    script = f"<script>{(STATIC / 'console.js').read_text()}</script>"

    def console() -> None:
        ui.add_head_html(head + script)
        OperatorPage(desk)

    def observe() -> None:
        ui.add_head_html(head)
        observer_page(desk)

    def picture(name: str, v: int = 0) -> Response:
        found = desk.pictures.jpeg(name)
        if found is None or (name == LIVE and found[0] == v):
            return Response(status_code=204)
        headers = {"X-Version": str(found[0]), "Cache-Control": "no-store"}
        return Response(found[1], media_type="image/jpeg", headers=headers)

    def moment(at: int) -> Response:
        data = desk.moments.jpeg(to_seconds(at))
        if data is None:
            return Response(NO_PICTURE, media_type="image/svg+xml", headers={"Cache-Control": "no-store"})
        return Response(data, media_type="image/jpeg", headers={"Cache-Control": "no-store"})

    def steps() -> None:
        ui.add_head_html(head)
        StepsPage(desk)

    ui.page("/", title="Wizard's console")(console)
    ui.page("/steps", title="What was shown")(steps)
    app.get("/moment/{at}")(moment)
    ui.page("/observe", title="This is what I believe")(observe)
    app.get("/picture/{name}")(picture)
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
