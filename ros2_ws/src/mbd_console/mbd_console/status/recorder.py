"""What the recorder reports of itself on diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

# Names of the recorder's report and of what is in it (mbd_bag/ros/recorder_report.py).
STATUS, MISSED, RECORDING, DISK_LEFT = "recorder: topics", "missed", "recording", "disk left [MB]"
SILENT = 7.0  # [s] without a report after which its recorder is in doubt; it reports every 2 s


@dataclass(frozen=True)
class RecorderState:
    """How the recording stands.

    Attributes:
        reported: when the last report came [s, a steady clock]; None before the first.
        recording: whether the bag is open.
        disk_left: [byte] on the bag's disk; None when it does not say.
        missed: messages it has missed, and ``words``, its own on it.
    """

    reported: float | None = None
    recording: bool = False
    disk_left: float | None = None
    missed: int = 0
    words: str = ""

    def records(self, now: float) -> bool:
        """Whether the bag is open, by a report that is not too old; ``now`` [s]: as in ``reported``."""
        return self.recording and self.reported is not None and now - self.reported <= SILENT


NO_REPORT = RecorderState()


def recorder_state(values: Mapping[str, str], words: str, at: float) -> RecorderState:
    """Of a report; raises ValueError when it counts in what is no number.

    Args:
        values: of the report.
        words: its message.
        at: now [s, a steady clock].
    """
    left = float(values[DISK_LEFT]) * 1e6 if DISK_LEFT in values else None
    # A recorder of an older version states nothing: it records as long as it lives.
    recording = values.get(RECORDING, "yes") == "yes"
    return RecorderState(at, recording, left, int(values.get(MISSED, "0")), words)
