"""The robots that the cell can be built with, by the names of arm and hand."""

from __future__ import annotations

from mbd_model.errors import MbdError

from mbd_cell.physics.arms import ARMS
from mbd_cell.physics.hands import HANDS
from mbd_cell.physics.robot_model import CellRobot


def cell_robot(arm: str, hand: str) -> CellRobot:
    """The robot of that arm and hand; raises MbdError, naming those there are."""
    for what, name, known in (("arm", arm, ARMS), ("hand", hand, HANDS)):
        if name not in known:
            raise MbdError(f"the cell has no {what} '{name}'; there are: {', '.join(known)}")
    return CellRobot(ARMS[arm], HANDS[hand], "jaco/" if (arm, hand) == ("jaco", "jaco") else "robot/")


JACO = cell_robot("jaco", "jaco")
