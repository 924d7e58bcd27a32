"""The docs' pictures of the console, taken again: ``python tests/system/console_pictures.py docs/img``."""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from console_session import Browser, console_session
from mbd_bringup.nodes import SessionOptions
from mbd_model.session import Phase

SIZES = {"": (1280, 800), "_tablet": (768, 1024)}
SETTLED = 1.0  # [s] until the live picture and the panels have followed


def take(folder: Path, every_size: bool = False) -> None:
    """Lead a sorting session to its second question and picture both pages; ``every_size``: on a tablet too."""
    with tempfile.TemporaryDirectory() as scratch:
        options = SessionOptions("p07", Path(scratch) / "p07", task="sorting", seed=3, threshold=0.6, speed=0.0)
        with console_session(options) as session:
            operator = Browser(session.address, Path(scratch) / "operator")
            observer = Browser(f"{session.address}/observe", Path(scratch) / "observer")
            session.lead(operator, lambda: session.phase is Phase.TUCK_AND_CLEAR)
            take_steps(session.address, Path(scratch) / "steps", folder)
            session.lead(operator, lambda: session.phase is Phase.ASSIST)
            session.lead(operator, lambda: session.asked_step == 2)
            operator.wait(lambda: operator.all(".step.asked[data-step='2']"), "the question is not shown")
            operator.note("teacher looked at both red cups first")
            for browser, name in ((operator, "console"), (observer, "console_observe")):
                for suffix, size in SIZES.items() if every_size else [("", SIZES[""])]:
                    browser.resize(*size)
                    time.sleep(SETTLED)
                    browser.driver.save_screenshot(str(folder / f"{name}{suffix}.png"))
                browser.driver.quit()


def take_steps(address: str, profile: Path, folder: Path) -> None:
    """Picture the page of the steps, the choices of the first one open."""
    steps = Browser(f"{address}/steps", profile, (1280, 900))
    steps.wait(lambda: steps.all(".carry figure"), "no step is shown")
    for summary in steps.all(".carry[data-carry='0'] summary"):
        summary.click()
    time.sleep(SETTLED)
    steps.driver.save_screenshot(str(folder / "console_steps.png"))
    steps.driver.quit()


if __name__ == "__main__":
    if len(sys.argv) < 2 or not Path(sys.argv[1]).is_dir():
        sys.exit(f"usage: {sys.argv[0]} FOLDER [--tablet]: the pictures go to that folder, which must be there")
    take(Path(sys.argv[1]), every_size="--tablet" in sys.argv[2:])
