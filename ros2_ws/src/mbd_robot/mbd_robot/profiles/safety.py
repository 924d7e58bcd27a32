"""What a driver says of its robot's safety, and which of it stops the suite: a part of a robot's profile."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from mbd_model.errors import MbdError


class SafetyCause(Enum):
    """Kinds of stops, named as in mbd_msgs/Stop."""

    EMERGENCY_STOP = "emergency_stop"
    PROTECTIVE_STOP = "protective_stop"


@dataclass(frozen=True)
class SafetyStop:
    """One value at which the robot stands.

    Attributes:
        value: of the field; of a bool 1 for true.
        cause: what kind of stop it is.
        says: what happened and what to do before the session is resumed, for people.
    """

    value: int
    cause: SafetyCause
    says: str

    def __post_init__(self) -> None:
        """A stop is said."""
        if not self.says:
            raise MbdError(f"says of value {self.value} is empty; expected a sentence for the operator")


@dataclass(frozen=True)
class SafetyTopic:
    """A topic that says how the robot is.

    Attributes:
        topic: its name.
        type: of its messages, as package/msg/Name.
        field: of the message that holds the state; of a message in it with a dot, as `errors.reflex`.
        well: a value at which the robot may move; the cell, which plays it, publishes it.
        stops: values at which everything stands until a person resumes; at all others the robot may move.
        latched: the driver publishes it on change only, and keeps the last for latecomers.
    """

    topic: str
    type: str
    field: str
    well: int
    stops: tuple[SafetyStop, ...]
    latched: bool = False

    def __post_init__(self) -> None:
        """A type has three parts, and a topic that stops nothing says nothing."""
        if len(self.type.split("/")) != 3 or "/msg/" not in self.type:
            raise MbdError(f"type is '{self.type}'; expected package/msg/Name")
        if not self.stops:
            raise MbdError("stops is empty; expected at least one value that stops the robot")
        if self.stop_at(self.well) is not None:
            raise MbdError(f"well is {self.well}, which is one of stops; expected a value at which the robot may move")

    def stop_at(self, value: int) -> SafetyStop | None:
        """The stop that this value is; None where the robot may move."""
        return next((s for s in self.stops if s.value == value), None)
