"""Makes the console's session importable, and what its tests share: browsers, and the console with a stand-in.

pytest's importlib mode does not put test folders on the path.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from console_browser import Browser
from console_stage import Open, Stage, console_stage


@pytest.fixture(scope="module")
def browsers() -> Iterator[list[Browser]]:
    opened: list[Browser] = []
    yield opened
    for browser in opened:
        browser.driver.quit()


@pytest.fixture
def browse(browsers: list[Browser], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Open]:
    """Opens a page in a browser that shows no other of this test; the tests after it use the browser again."""
    used: list[Browser] = []

    def open_page(address: str) -> Browser:
        if len(used) == len(browsers):
            browsers.append(Browser(address, tmp_path_factory.mktemp("profile")))
        else:
            browsers[len(used)].show(address)
        used.append(browsers[len(used)])
        return used[-1]

    yield open_page
    for browser in used:
        browser.show("about:blank")


@pytest.fixture(scope="module")
def one_stage(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stage]:
    with console_stage(tmp_path_factory.mktemp("stage")) as running:
        yield running


@pytest.fixture
def stage(one_stage: Stage) -> Stage:
    one_stage.rest()
    return one_stage


@pytest.fixture
def fresh_stage(tmp_path: Path) -> Iterator[Stage]:
    """A console of this test's own."""
    with console_stage(tmp_path) as running:
        running.rest()
        yield running
