"""The recording of one session: its bag is closed when the session ends, and goes on when somebody says more."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping

from mbd_model.session import Phase

from mbd_bag.errors import BagError
from mbd_bag.recorder.bag_output import BagOutput
from mbd_bag.recorder.memory_budget import MemoryBudget
from mbd_bag.recorder.parameters import RecorderConfig
from mbd_bag.recorder.session_span import SessionSpan
from mbd_bag.recorder.topic_counts import TopicCount
from mbd_bag.session.session_facts import fingerprint


class SessionRecording:
    """Owns the bag.

    Args:
        config: of the recorder.
        warn: takes one sentence when something is amiss.
        inform: takes one sentence when the bag is opened or closed; it names no folder of the machine.

    Attributes:
        budget: of the memory for what waits to be written.
        counts: what became of the messages, by topic.
        output: what messages are handed to while ``open``.
        open: whether the bag is; not between the session's end and a word that comes later.
        failed: whether a bag could not be closed.
        on_flushed: is called with the file's name when the bag's file was flushed, in the thread that writes it.

    Raises:
        BagError: a parameter or the bag's place cannot be used.
    """

    def __init__(self, config: RecorderConfig, warn: Callable[[str], object], inform: Callable[[str], object]) -> None:
        self._config, self._warn, self._inform = config, warn, inform
        self._facts: dict[str, str] = config.plan_facts
        self.budget = MemoryBudget(int(config.memory * 1e6))
        self.counts: dict[str, TopicCount] = {}
        self._span = SessionSpan(follows=config.end_with_session)
        self.failed = False
        self.on_flushed: Callable[[str], object] = lambda _: None
        self.output = BagOutput(config, self.budget, warn, flushed=self._flushed)
        self.open = True
        self.output.add_facts(self._facts)
        self._say_where()

    @property
    def failure(self) -> Exception | None:
        """Why writing stopped, None while all is well."""
        return self.output.failure

    def _flushed(self, file: str) -> None:
        self.on_flushed(file)

    def _say_where(self) -> None:
        self._inform(f"recording to {self.output.writer.path.name}")
        _print(f"recording to {self.output.writer.path}")

    def add_facts(self, facts: Mapping[str, str]) -> None:
        """Facts of the session, which each file of its bag states."""
        self._facts |= facts
        self.state_now(facts)

    def state_now(self, facts: Mapping[str, str]) -> None:
        """Facts of this moment."""
        if self.open:
            self.output.add_facts(facts)

    def enter(self, phase: Phase) -> bool:
        """The session states its phase; False when that is no news after its end."""
        was_over = self._span.over
        self._span.enter(phase, time.monotonic())
        return not (was_over and self._span.over)

    def takes(self, topic: str, *, large: bool) -> bool:
        """Whether a message that has just arrived is recorded; opens the bag for it when it was closed.

        Args:
            topic: it came on.
            large: whether it is a picture or a cloud, of which the ones after the end count for nothing.
        """
        if not self._span.keeps(topic, time.monotonic()) or (large and self._span.over):
            return False
        return self.open or self._open_again()

    def _open_again(self) -> bool:
        try:
            self.output = BagOutput(self._config, self.budget, self._warn, again=True, flushed=self._flushed)
        except BagError as error:
            self._warn(f"what comes after the session's end is not recorded: {error}")
            return False
        self.open = True
        self.output.add_facts(self._facts)
        self._say_where()
        return True

    def over(self) -> bool:
        """Whether the session is over, and nobody has said a word for a while: the bag is to be closed."""
        return self.open and self.failure is None and self._span.closes(time.monotonic())

    def close(self) -> None:
        """Write what has arrived and finish the bag; states on stdout what is in it, on stderr why it failed."""
        if not self.open:
            return
        self.open = False
        folder = self.output.writer.folder
        self.output.add_facts({"fingerprint": fingerprint(self._facts)})
        try:
            self.output.close(self.counts)
        except (OSError, ValueError, BagError) as error:
            self.failed = True
            sys.stderr.write(f"recorder: writing stopped: {error}. What was written is in {folder}\n")
            return
        counts = self.output.writer.counts
        _print(f"{sum(counts.values())} messages on {len(counts)} topics in {folder}")


def _print(text: str) -> None:
    sys.stdout.write(f"recorder: {text}\n")
    sys.stdout.flush()
