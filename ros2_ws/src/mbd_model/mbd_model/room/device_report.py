"""What a program that films the room with devices says of itself on diagnostics, once a second while it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

STATUS = "room_device: film"  # name of the report
_NAME, _SOUND, _PICTURE, _STATE = "film", "sound", "picture", "state"
_GROWS, _ENDED, _LOST = "recording", "ended", "lost"


@dataclass(frozen=True)
class DeviceReport:
    """One report.

    Attributes:
        name: of the film's file, without ending.
        sound, picture: whether the film has them.
        ended: the film was to end, and did.
        lost: why a device or the disk ended it, "" while neither has.
    """

    name: str
    sound: bool
    picture: bool
    ended: bool = False
    lost: str = ""

    @property
    def values(self) -> dict[str, str]:
        """The report's values; ``lost`` is its message."""
        state = _LOST if self.lost else _ENDED if self.ended else _GROWS
        return {_NAME: self.name, _SOUND: _word(self.sound), _PICTURE: _word(self.picture), _STATE: state}


def device_report(values: Mapping[str, str], message: str) -> DeviceReport:
    """The report of these values; whoever sends others is taken to film with all it has.

    Args:
        values: of the report.
        message: its words.
    """
    state = values.get(_STATE, _GROWS)
    lost = (message or state) if state == _LOST else ""
    sound, picture = values.get(_SOUND, "yes") == "yes", values.get(_PICTURE, "yes") == "yes"
    return DeviceReport(values.get(_NAME, "room"), sound, picture, state == _ENDED, lost)


def _word(true: bool) -> str:
    return "yes" if true else "no"
