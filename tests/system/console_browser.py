"""A headless Chromium with one page of the console: what it shows, and how it is pressed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from mbd_model.session import Phase
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.ui import WebDriverWait

CHROMIUM, DRIVER = Path("/usr/bin/chromium"), Path("/usr/bin/chromedriver")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--force-prefers-reduced-motion",  # a blinking dot takes 7 % of a core, drawn in software
)
# The middle of an element, where nothing else lies over it.
SEEN_AT = """
    const found = document.querySelector(arguments[0]);
    if (!found) return null;
    const box = () => found.getBoundingClientRect();
    if (box().top < 0 || box().bottom > innerHeight) found.scrollIntoView({block: "center"});
    const [x, y] = [(box().left + box().right) / 2, (box().top + box().bottom) / 2];
    const hit = document.elementFromPoint(x, y);
    return hit && (found.contains(hit) || hit.closest("g") === found.closest("g")) ? [x, y] : null;
"""


def question_about(step: int) -> str:
    """Selector of the banner while it asks about a step, counted from 0."""
    return f".prompt.question[data-step='{step}']"


class Browser:
    """A headless Chromium with one console page."""

    def __init__(
        self, address: str, profile: Path, size: tuple[int, int] = (1280, 800), flags: tuple[str, ...] = ()
    ) -> None:
        options = webdriver.ChromeOptions()
        options.binary_location = str(CHROMIUM)
        for flag in (*FLAGS, *flags, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(str(DRIVER)))
        self.show(address, size)

    def show(self, address: str, size: tuple[int, int] = (1280, 800)) -> None:
        """Open another page in place of the one it has."""
        self.resize(*size)
        self.driver.get(address)

    def close(self) -> None:
        self.driver.quit()

    def resize(self, width: int, height: int) -> None:
        """Make the page, not the window, that large [px]."""
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
        )

    def all(self, selector: str) -> list[WebElement]:
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def text(self, selector: str) -> str:
        """All text of the elements there, whether scrolled into view or not; read at once, as panels are replaced."""
        script = "return [...document.querySelectorAll(arguments[0])].map(e => e.textContent).join('\\n')"
        return str(self.driver.execute_script(script, selector))

    def wait(self, what: Callable[[], object], why: str, timeout: float = 60.0) -> None:
        # The page is drawn again while it is read: what has gone then is looked for again.
        waiting = WebDriverWait(self.driver, timeout, 0.1, ignored_exceptions=[StaleElementReferenceException])
        waiting.until(lambda _: what(), why)

    def says(self, selector: str, text: str, why: str = "") -> None:
        """Until that text is among the elements there: a page just opened is drawn again as messages come in."""
        self.wait(lambda: text in self.text(selector), why or f"{selector!r} does not come to say {text!r}")

    def press(self, selector: str, number: int = 0) -> None:
        """Click one of the elements there, found again if the page is drawn between finding and clicking."""

        def click() -> bool:
            found = self.all(selector)
            if len(found) <= number:
                return False
            found[number].click()
            return True

        self.wait(click, f"no {selector!r} number {number} to click")

    def be_tablet(self) -> None:
        """Be a tablet held upright from now on, on which nothing but fingers points."""
        metrics = {"width": 768, "height": 1024, "deviceScaleFactor": 1, "mobile": True}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        self.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 1})

    def tap(self, selector: str) -> None:
        """Touch the first of the elements there with a finger, where it is seen, scrolled to if need be."""

        def touch() -> bool:
            place = self.driver.execute_script(SEEN_AT, selector)
            if place is None:
                return False
            finger = {"x": place[0], "y": place[1]}
            for kind, points in (("touchStart", [finger]), ("touchEnd", [])):
                self.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
            return True

        self.wait(touch, f"no {selector!r} that a finger can touch")

    def key(self, key: str) -> None:
        webdriver.ActionChains(self.driver).send_keys(key).perform()

    def click(self, action: str) -> None:
        self.press(f"[data-action={action}]:not([disabled])")

    def click_object(self, object_id: str) -> None:
        self.press(f".choosing [data-object={object_id}] .name")

    def phase(self) -> Phase | None:
        """The phase the page shows as the present one."""
        script = "return document.querySelector('.phases .now')?.dataset.phase"
        name = self.driver.execute_script(script)
        return Phase[name] if name else None

    def note(self, text: str) -> None:
        self.key("t")
        self.key(text + Keys.ENTER)
