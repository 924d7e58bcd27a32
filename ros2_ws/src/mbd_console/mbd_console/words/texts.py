"""The one table of the pages' texts, texts.yaml: each by its name in every language."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

LANGUAGES = {"en": "English", "de": "Deutsch"}
TABLE = Path(__file__).parent / "texts.yaml"


@cache
def table() -> dict[str, dict[str, Any]]:
    """Name -> language -> text, as the file has it."""
    read: dict[str, dict[str, Any]] = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    return read


@dataclass(frozen=True)
class PageTexts:
    """The texts of a page in one language.

    Attributes:
        language: ISO 639-1 code, one of ``LANGUAGES``.
    """

    language: str = "en"

    def __call__(self, name: str, /, **values: object) -> str:
        """A text with its places filled in; raises KeyError for a text there is not."""
        text: str = table()[name][self.language]
        return text.format(**values) if values else text

    def has(self, name: str) -> bool:
        """Whether there is a text of that name."""
        return name in table()


ENGLISH = PageTexts()


def texts_in(language: object) -> PageTexts:
    """The texts for what a browser asked for; English for anything that is no language of the table."""
    return PageTexts(language if isinstance(language, str) and language in LANGUAGES else "en")
