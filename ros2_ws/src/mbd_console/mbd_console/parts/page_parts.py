"""Parts that the pages share: panels, the language's switch, the veil over a page without a connection."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from mbd_console.palette import safe
from mbd_console.words.texts import LANGUAGES, PageTexts

PERIOD = 0.1  # [s] between two looks at what changed


class Panel:
    """A part of a page whose HTML is sent only when it changed. Its text is escaped where it is made."""

    def __init__(self, name: str, make: Callable[[], str], props: str = "") -> None:
        self._make, self._last = make, ""
        self._element = ui.html("", sanitize=False).classes(f"panel {name}").props(props)

    def refresh(self) -> None:
        """Make it again."""
        content = self._make()
        if content != self._last:
            self._last = content
            self._element.set_content(content)


def language_links(texts: PageTexts, path: str) -> None:
    """A link to the same page in each other language, in that language's own words."""
    with ui.element("nav").classes("languages").props(f'aria-label="{safe(texts("language"))}"'):
        for code, name in LANGUAGES.items():
            if code != texts.language:
                ui.link(name, f"{path}?lang={code}").classes("other").props(f"lang={code} hreflang={code}")


def veil(texts: PageTexts, words: str) -> None:
    """What covers a page that lost its console, and says when it is back; static/shared.js shows it."""
    lost = f"<div><b>{safe(texts('lost_title'))}</b><p>{safe(texts(words))}</p></div>"
    ui.html(
        f'<div id="veil" role="alert" hidden>{lost}</div>'
        f'<div id="back" role="status" aria-live="polite" data-words="{safe(texts("back_again"))}"></div>',
        sanitize=False,
    )


def head_of(texts: PageTexts, title: str) -> str:
    """Script that names the page's language before anything is read, and its title."""
    ui.page_title(texts(title))
    return f'<script>document.documentElement.lang = "{texts.language}";</script>'
