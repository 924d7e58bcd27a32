"""``session``: the launch file's session by one command, which says where its page is, and ends with one Ctrl-C."""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import socket
import sys
import time
from collections.abc import Mapping

from mbd_console.access.port import refuse_taken_port
from mbd_model.errors import MbdError
from mbd_model.session import Phase
from rich.console import Console
from rich.markup import escape

from mbd_bringup.launch_arguments import options_of
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.planned_words import planned_words
from mbd_bringup.processes import Deaths
from mbd_bringup.ros.event_lines import print_event
from mbd_bringup.ros.known_tasks import refuse_unknown_task
from mbd_bringup.ros.live_session import OVER, LiveSession
from mbd_bringup.ros.next_offer import NextOffer
from mbd_bringup.session_words import all_words, given_words, words_of_next

_PATIENCE = 20.0  # [s] for the recorder to close its bag, once the session is done


class LedSession:
    """One session, from its nodes' start to its operator's last word.

    Args:
        given: the arguments a person gave, by name.
        console: where its events are printed.

    Raises:
        MbdError: an argument that cannot be used.
    """

    def __init__(self, given: Mapping[str, str], console: Console) -> None:
        self._given, self._console = dict(given), console
        words = all_words(self._given)
        self.options: SessionOptions = options_of(words, self._given)
        refuse_unknown_task(self.options)
        if self.options.console:
            refuse_taken_port("127.0.0.1", self.options.port, "--port 8081")
        self._page_said = not self.options.console
        self._closed_said = False
        self._deaths = Deaths()

    def lead(self) -> tuple[Phase | None, bool]:
        """Run it; returns the phase it ended in, and whether the plan's next is to begin.

        Raises:
            MbdError: a node did not come up again and again.
            KeyboardInterrupt: Ctrl-C; every node was ended.
        """
        options, begun, over_since = self.options, time.monotonic(), 0.0
        with LiveSession(options, domain=int(os.environ.get("ROS_DOMAIN_ID") or 0)) as live:
            offer = NextOffer(live.follower)
            self._say(f"[dim]ROS_DOMAIN_ID={live.domain}; the nodes' output goes to {escape(str(live.logs))}[/]")
            for fact in options.plan:
                if fact.startswith("deviation="):
                    self._say(f"[yellow]not as planned:[/] {escape(fact.partition('=')[2])}; its bag states that")
            if options.led_by_person and not options.console:
                self._say("[dim]you are the operator: ./mbd run mbd_interaction say next_phase (docs/wizard.md)[/]")
            while not offer.begun:
                with contextlib.suppress(queue.Empty):
                    event = live.follower.events.get(timeout=0.1)
                    live.phase = event.phase or live.phase
                    print_event(event, time.monotonic() - begun, self._console)
                self._restart_dead(live)
                self._say_page()
                if live.phase not in OVER:
                    over_since, self._closed_said = 0.0, False
                    continue
                over_since = over_since or time.monotonic()
                if not self._closed_said and (self._bag_closed() or time.monotonic() - over_since > _PATIENCE):
                    self._closed_said = True
                    self._say_recorded()
                    self._offer_next(offer)
                if self._closed_said and not options.led_by_person:
                    break
            return live.phase, offer.begun

    def _say(self, text: str) -> None:
        self._console.print(text, highlight=False, soft_wrap=True)

    def _say_page(self) -> None:
        """State the page's address, once somebody who opens it is answered."""
        if self._page_said:
            return
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.options.port), timeout=0.2):
            self._page_said = True
            address = f"http://127.0.0.1:{self.options.port}"
            self._say(f"[bold green]console at {address}/, for the participant at {address}/observe[/]")

    def _bag_closed(self) -> bool:
        return (self.options.bag / "metadata.yaml").exists()

    def _say_recorded(self) -> None:
        bag = self.options.bag
        size = sum(f.stat().st_size for f in bag.glob("*.mcap")) / 1e6 if bag.is_dir() else 0.0
        state = "the recording has ended" if self._bag_closed() else "[red]the bag is not closed yet[/]"
        stays = "; the pages stay until Ctrl-C, and what is said until then is recorded" if self._stays else ""
        self._say(f"[bold green]{state}:[/] {size:.1f} MB in {escape(str(bag))}{stays}")

    @property
    def _stays(self) -> bool:
        return self.options.led_by_person

    def _offer_next(self, offer: NextOffer) -> None:
        """Offer what the plan has next, when there is a plan."""
        if "plan" not in self._given or not self._stays:
            return
        given = words_of_next(self._given)
        try:
            planned = planned_words(all_words(given), given).planned
            offer.offer(planned)
        except MbdError as error:
            offer.offer(None, str(error))
            self._say(f"next: {escape(str(error))}")
            return
        if planned is not None:
            self._say(f"next: {planned.session} ({planned.task}, {planned.condition}); the console's button begins it")

    def _restart_dead(self, live: LiveSession) -> None:
        """Start a node again that ended by itself; raises MbdError for one that does not come up."""
        for node in live.processes.dead():
            ended = f"node '{node.name}' ended with code {node.process.returncode}"
            if self._deaths.gives_up(node.name, node.process.returncode, time.monotonic() - node.started):
                raise MbdError(f"{ended}; the end of {node.log}:\n{node.log_tail()}")
            self._say(f"[yellow]{ended} and is started again; why is in {escape(str(node.log))}[/]")
            live.processes.start(node.spec)


def _interrupt(number: int, frame: object) -> None:
    # Once: a second one must not break off the closing of the bag.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    # Stopping the nodes takes seconds: said at once, and past every buffer, as this may break into another print.
    os.write(sys.stdout.fileno(), b"\nending every node and closing the bag, wait a moment\n")
    raise KeyboardInterrupt


def lead_in_turn(given: Mapping[str, str], console: Console, session: type[LedSession] = LedSession) -> Phase | None:
    """Lead a session, and the plan's next one as often as its operator begins it; returns the phase the last ended in.

    Args:
        given: the arguments a person gave, by name.
        console: where events are printed.
        session: what leads each of them.

    Raises:
        MbdError: an argument that cannot be used, or a node that did not come up.
        KeyboardInterrupt: Ctrl-C; every node was ended.
    """
    words, again = dict(given), True
    phase: Phase | None = None
    while again:
        phase, again = session(words, console).lead()
        words = words_of_next(words)
    return phase


def main() -> None:
    """Entry point: exit code 0 when the session was done, 1 when it was not, 130 when it was interrupted before."""
    console = Console()
    try:
        given = given_words()
        signal.signal(signal.SIGINT, _interrupt)
        signal.signal(signal.SIGTERM, _interrupt)
        phase = lead_in_turn(given, console)
    except KeyboardInterrupt:
        console.print("[red]interrupted[/]: every node was ended; what was recorded is in the session's bag")
        sys.exit(130)
    except MbdError as error:
        console.print(f"[red]session:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(1)
    sys.exit(0 if phase is Phase.DONE else 1)
