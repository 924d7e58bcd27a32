"""The desk all pages share: the one state they show, what changes it, and where requests go."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from mbd_model.objects import Role

from mbd_console.pictures import PictureStore
from mbd_console.requests import ConsoleRequest
from mbd_console.room.shown import ShownFilm
from mbd_console.room.store import RoomStore
from mbd_console.state import ConsoleState, logged
from mbd_console.status.event_log import Tone
from mbd_console.steps.moments import MomentPictures
from mbd_console.study.form_plan import PlannedForm

Change = Callable[[ConsoleState], ConsoleState]


@dataclass
class Desk:
    """Hands over between the ROS thread, which posts changes and takes requests, and the web server's, which shows.

    Attributes:
        send: passes a request on to ROS; may be called from any thread.
        now: the session's clock [s].
        pictures: what the camera saw.
        moments: what it saw while the demonstration was given.
        room: films of the room, beside the bag.
        state: what the pages show; only the web server's thread replaces it.
        version: grows with each change of it.
        forms: of the study.
        language: of the pages that ask for none.
        on_change: called with the state before and after each change, in the web server's thread.
    """

    send: Callable[[ConsoleRequest], None]
    now: Callable[[], float]
    pictures: PictureStore = field(default_factory=PictureStore)
    moments: MomentPictures = field(default_factory=MomentPictures)
    room: RoomStore = field(default_factory=lambda: RoomStore(None, time.monotonic))
    state: ConsoleState = field(default_factory=ConsoleState)
    version: int = 0
    forms: tuple[PlannedForm, ...] = ()
    language: str = "en"
    on_change: Callable[[ConsoleState, ConsoleState], None] | None = None
    _changes: queue.SimpleQueue[Change] = field(default_factory=queue.SimpleQueue)

    @property
    def films(self) -> tuple[ShownFilm, ...]:
        """The films of the room that grow, or were meant to: by pages and by devices."""
        return (*self.room.shown, *self.state.filmed)

    def post(self, change: Change) -> None:
        """Have the state changed; from any thread."""
        self._changes.put(change)

    def catch_up(self) -> None:
        """Apply what was posted; in the web server's thread only."""
        while True:
            try:
                change = self._changes.get_nowait()
            except queue.Empty:
                return
            before, self.state = self.state, change(self.state)
            self.version += 1
            if self.on_change is not None:
                self.on_change(before, self.state)

    def refuse(self, reason: str) -> None:
        """Show on every page that something was not passed on."""
        at = self.now()
        self.post(lambda state: logged(state, at, Tone.REFUSED, "console", reason))

    def picture_addresses(self) -> dict[Role, str]:
        """Where a page finds each scene's picture; "" where there is none."""
        versions = {role: self.pictures.version(role) for role in Role}
        return {role: f"/picture/{role}?v={version}" if version else "" for role, version in versions.items()}
