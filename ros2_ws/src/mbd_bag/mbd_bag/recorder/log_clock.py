"""Log times that never go back, also before a simulation's clock has started."""

from __future__ import annotations


class LogClock:
    """Gives each message its log time.

    Simulated time reads 0 until the first /clock, and a restarted simulation starts again from 0. A message is then
    logged at the latest time known so far, so that a bag read in order of log time is read in the order recorded.

    Args:
        latest: where to start: the last log time of a bag gone on with [ns].
    """

    def __init__(self, latest: int = 0) -> None:
        self._latest = latest

    @property
    def latest(self) -> int:
        """The latest log time so far [ns]; 0 before the first."""
        return self._latest

    def stamp(self, now: int) -> int:
        """Log time of a message received at ``now`` [ns] by the clock in use."""
        self._latest = max(self._latest, now)
        return self._latest
