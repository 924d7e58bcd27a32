"""The docs' pictures of the console, taken again: ``python tests/system/console_pictures.py docs/img``."""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
import time
from pathlib import Path

from console_browser import Browser
from console_session import console_session
from mbd_bringup.nodes import SessionOptions
from mbd_model.session import Phase
from PIL import Image

SIZES = {"": (1280, 800), "_tablet": (768, 1024)}
SETTLED = 1.5  # [s] until the live picture and the panels have followed
COLORS = 256  # of a picture: no page has more that anybody would miss
FORM = "nasa_tlx"


def take(folder: Path, every_size: bool = False) -> None:
    """Lead a sorting session to its second question and picture each page; ``every_size``: on a tablet too."""
    with tempfile.TemporaryDirectory() as scratch:
        options = SessionOptions(
            "p07", Path(scratch) / "p07", task="sorting", seed=3, threshold=1.0, speed=0.0, forms=(FORM,)
        )
        with console_session(options) as session, contextlib.ExitStack() as stack:

            def opened(path: str, name: str) -> Browser:
                browser = Browser(f"{session.address}{path}", Path(scratch) / name)
                stack.callback(browser.close)
                return browser

            operator, participant = opened("/", "operator"), opened("/observe?lang=de", "participant")
            session.lead(operator, until=lambda: session.phase is Phase.TUCK_AND_CLEAR)
            take_steps(opened("/steps", "steps"), folder)
            session.lead(operator, until=lambda: session.phase is Phase.ASSIST)
            session.lead(operator, until=lambda: session.asked_step == 2)
            operator.wait(lambda: operator.all(".step.asked[data-step='2']"), "the question is not shown")
            operator.note("teacher looked at both red cups first")
            for browser, name in ((operator, "console"), (participant, "console_observe")):
                for suffix, size in SIZES.items() if every_size else [("", SIZES[""])]:
                    browser.resize(*size)
                    keep(browser, folder / f"{name}{suffix}.png")
                browser.resize(*SIZES[""])
            operator.key("v")
            operator.driver.execute_script("emitEvent('study', {do: 'form', name: arguments[0]})", FORM)
            participant.wait(lambda: participant.all(f"[data-form={FORM}]"), "no form is shown")
            keep(participant, folder / "console_form.png")
            keep(operator, folder / "console_study.png")


def take_steps(steps: Browser, folder: Path) -> None:
    """Picture the page of the steps, the choices of the first one open."""
    steps.resize(1280, 900)
    steps.wait(lambda: steps.all(".carry figure"), "no step is shown")
    steps.driver.execute_script(
        "document.querySelectorAll(\".carry[data-carry='0'] details\").forEach(e => e.open = true)"
    )
    keep(steps, folder / "console_steps.png")


def keep(browser: Browser, path: Path) -> None:
    """Write what a page shows, small."""
    time.sleep(SETTLED)
    shown = Image.open(io.BytesIO(browser.driver.get_screenshot_as_png())).convert("RGB")
    shown.quantize(COLORS, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    if len(sys.argv) < 2 or not Path(sys.argv[1]).is_dir():
        sys.exit(f"usage: {sys.argv[0]} FOLDER [--tablet]: the pictures go to that folder, which must be there")
    take(Path(sys.argv[1]), every_size="--tablet" in sys.argv[2:])
