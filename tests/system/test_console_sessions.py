"""Sessions of all five tasks, led by an operator who has the console's page and nothing else."""

from __future__ import annotations

import re
import subprocess
from contextlib import closing
from pathlib import Path

import pytest
from console_session import CHROMIUM, DRIVER, Browser, console_session
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.live_session import install_prefixes
from mbd_model.session import Phase

pytestmark = [
    pytest.mark.timeout(900),
    pytest.mark.skipif(
        not (CHROMIUM.exists() and DRIVER.exists()), reason="needs a browser: apt-get install chromium chromium-driver"
    ),
]


# Thresholds that no estimate passes early, so that there is much to answer.
@pytest.mark.parametrize(
    ("task", "seed", "threshold"),
    [
        ("stacking", 2, 0.9),
        ("sorting", 3, 0.6),
        ("lunch_packing", 1, 1.0),
        ("dish_sorting", 1, 1.0),
        ("assembly", 1, 1.0),
    ],
)
def test_a_complete_session_is_led_to_the_right_mapping_by_clicks_and_keys_alone(
    task: str, seed: int, threshold: float, tmp_path: Path
):
    options = SessionOptions("console", tmp_path / "console", task=task, seed=seed, threshold=threshold, speed=0.0)
    with console_session(options) as session, closing(Browser(session.address, tmp_path / "profile")) as browser:
        browser.wait(browser.phase, "the page does not state where the session is")
        session.lead(browser, lambda: session.phase is Phase.ASSIST)
        browser.wait(lambda: browser.all(".camera.seen"), "no live picture")
        browser.wait(lambda: len(browser.all(".step")) >= 6, "the steps are not shown")
        browser.wait(lambda: len(browser.all(".mapping image")) == 2, "the mapping lacks one of its two pictures")
        session.lead(browser, lambda: session.phase is Phase.DONE)
        browser.wait(lambda: browser.phase() is Phase.DONE, "the page does not see the end")
        browser.wait(lambda: len(browser.all(".confidence circle")) >= 2, "the confidence has no course")
        assert session.processes.stop(patience=20) == []
    table = install_prefixes(["mbd_study"])["mbd_study"] / "lib" / "mbd_study" / "table"
    shown = subprocess.run([str(table), str(options.bag)], capture_output=True, text=True, check=False).stdout
    assert re.findall(r"\b(right|wrong)\b", shown)[-1] == "right", shown
