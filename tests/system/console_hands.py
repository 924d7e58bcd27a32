"""How an operator presses what he means: by mouse, by keyboard alone, or with a finger on a tablet."""

from __future__ import annotations

from enum import Enum

from console_browser import Browser
from mbd_cell.teacher.wizard import WizardAct

KEY = {
    WizardAct.OPEN: "o",
    WizardAct.CLOSE: "c",
    WizardAct.START: "s",
    WizardAct.STOP: "e",
    WizardAct.NEXT_PHASE: "n",
    WizardAct.SKIP: "k",
    WizardAct.YES: "y",
    WizardAct.NO: "w",
}
BUTTON = {
    WizardAct.OPEN: "open",
    WizardAct.CLOSE: "close",
    WizardAct.START: "start",
    WizardAct.STOP: "stop",
    WizardAct.NEXT_PHASE: "next",
    WizardAct.SKIP: "skip",
    WizardAct.YES: "yes",
    WizardAct.NO: "no",
}


class Hand(Enum):
    """With what an operator presses."""

    MOUSE = 1
    KEYS = 2
    FINGER = 3

    def do(self, browser: Browser, act: WizardAct) -> None:
        """Press what stands for an act; only what the page offers can be pressed."""
        if self is Hand.KEYS:
            browser.key(KEY[act])
        elif self is Hand.MOUSE:
            browser.click(BUTTON[act])
        else:
            browser.tap(f"[data-action={BUTTON[act]}]:not([disabled])")

    def choose(self, browser: Browser, object_id: str, number: int) -> None:
        """Choose an object; ``number``: the key that stands for it."""
        if self is Hand.KEYS:
            browser.key(str(number))
        elif self is Hand.MOUSE:
            browser.click_object(object_id)
        else:
            browser.tap(f".choosing [data-object={object_id}] .name")
