"""How an arm is made soft for a hand that guides it: a part of a robot's profile."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from mbd_model.errors import MbdError


class GuidingSwitch(Enum):
    """How the arm is made soft for a hand that guides it."""

    KINOVA_FORCE_CONTROL = "kinova_force_control"
    CONTROLLERS = "controllers"
    FREEDRIVE = "freedrive"
    PERSON = "person"


@dataclass(frozen=True)
class GuidingProfile:
    """How a person may guide the arm by hand.

    Attributes:
        switch: how it is switched on.
        enable, disable: services; or names of controllers to activate and deactivate, separated by blanks; or of
            freedrive its topic, and then its controller and the one that it takes the arm from.
        instruction: what a person must do besides, or instead; shown to the operator.
    """

    switch: GuidingSwitch
    enable: str = ""
    disable: str = ""
    instruction: str = ""

    def __post_init__(self) -> None:
        """A person needs an instruction, a driver a name."""
        if self.switch is GuidingSwitch.PERSON and not self.instruction:
            raise MbdError("switch is person, and no instruction is given")
        if self.switch is not GuidingSwitch.PERSON and not self.enable:
            raise MbdError(f"switch is {self.switch.value}, and what to switch on is not given")
