"""A form: its items in several languages, and the scores that its answers give."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum, StrEnum

from mbd_model.errors import MbdError


class FormError(MbdError):
    """A form, or an answer to one, that cannot be used."""


class ItemKind(IntEnum):
    """What an item asks for; values equal mbd_msgs/FormAnswer."""

    TEXT = 1
    CHOICE = 2
    SCALE = 3
    NUMBER = 4
    YES_NO = 5
    AGREE = 6


class ScoreRule(StrEnum):
    """How a score comes of its items.

    MEAN: of the answers, a reversed one counted from the other end of its scale. SUM_FROM_ZERO: the sum of each
    answer's distance from the low end of its scale (a reversed one's, from the high end).
    """

    MEAN = "mean"
    SUM_FROM_ZERO = "sum_from_zero"


@dataclass(frozen=True)
class LocalText:
    """A text in several languages, as (ISO 639-1 code, text); the first is shown where one lacks."""

    texts: tuple[tuple[str, str], ...]

    def __post_init__(self) -> None:
        """Validate once; raises FormError for a text without words."""
        if not self.texts or any(not language or not text for language, text in self.texts):
            raise FormError(f"a text of a form is {dict(self.texts)}: expected words for each language, as en: Age")

    def in_language(self, language: str) -> str:
        """The text for who reads that language."""
        return dict(self.texts).get(language, self.texts[0][1])

    @property
    def languages(self) -> frozenset[str]:
        """Codes of those it has."""
        return frozenset(language for language, _ in self.texts)


@dataclass(frozen=True)
class AnswerScale:
    """Steps from ``low`` to ``high``, ``step`` apart, with words at both ends."""

    low: float
    high: float
    step: float
    low_words: LocalText
    high_words: LocalText

    def __post_init__(self) -> None:
        """Validate once; raises FormError for a scale without whole steps."""
        steps = (self.high - self.low) / self.step if self.step else math.nan
        if not (math.isfinite(steps) and 1 <= steps <= 100 and abs(steps - round(steps)) < 1e-9):
            raise FormError(f"a scale from {self.low:g} to {self.high:g} by {self.step:g} has not 1 to 100 whole steps")

    @property
    def values(self) -> tuple[float, ...]:
        """Every answer it takes, from the low end."""
        return tuple(self.low + k * self.step for k in range(round((self.high - self.low) / self.step) + 1))


@dataclass(frozen=True)
class FormItem:
    """One thing that a form asks.

    Attributes:
        name: unique in its form.
        kind: what it asks for.
        text: of the question, or the sentence agreed to.
        required: without an answer the form is not taken.
        options: of a CHOICE: (name, words) each; else ().
        scale: of a SCALE; else None.
        limits: (least, greatest) of a NUMBER.
    """

    name: str
    kind: ItemKind
    text: LocalText
    required: bool = False
    options: tuple[tuple[str, LocalText], ...] = ()
    scale: AnswerScale | None = None
    limits: tuple[float, float] = (-math.inf, math.inf)

    def __post_init__(self) -> None:
        """Validate once; raises FormError naming the item."""
        if (self.kind is ItemKind.CHOICE) != (len({n for n, _ in self.options}) >= 2):
            raise FormError(f"item '{self.name}': a choice, and nothing else, has two or more options, each once")
        if (self.kind is ItemKind.SCALE) != (self.scale is not None):
            raise FormError(f"item '{self.name}': a scale item, and no other, has a scale")


@dataclass(frozen=True)
class ScoreOfItems:
    """``factor`` times what ``rule`` makes of the items named, ``reversed_items`` among them counted from the end."""

    name: str
    rule: ScoreRule
    items: tuple[str, ...]
    reversed_items: tuple[str, ...] = ()
    factor: float = 1.0


@dataclass(frozen=True)
class StudyForm:
    """A form as a participant fills it in.

    Attributes:
        name: as files, messages and tables call it: "nasa_tlx".
        version: of its text; what was signed or answered is of that version.
        title, intro: shown above the items; ``intro`` may be None.
        items: in order.
        scores: that its answers give.
        consent: only who agrees takes part: it can be declined, and is not taken without every AGREE.
        source: where the instrument is from, and ``licence``, on which ground its words are here; "" for one's own.
    """

    name: str
    version: str
    title: LocalText
    intro: LocalText | None
    items: tuple[FormItem, ...]
    scores: tuple[ScoreOfItems, ...] = ()
    consent: bool = False
    source: str = ""
    licence: str = ""

    def __post_init__(self) -> None:
        """Validate once; raises FormError naming form and item."""
        names = [item.name for item in self.items]
        twice = sorted({n for n in names if names.count(n) > 1})
        if not names or twice:
            raise FormError(
                f"form '{self.name}' has {f'items {twice} twice' if twice else 'no item'}: give each a name"
            )
        scales = {item.name for item in self.items if item.kind is ItemKind.SCALE}
        for score in self.scores:
            wrong = sorted(
                {*score.items, *score.reversed_items} - scales | set(score.reversed_items) - set(score.items)
            )
            if wrong or not score.items:
                raise FormError(
                    f"form '{self.name}', score '{score.name}': {wrong or 'nothing'} is no scale item of it"
                )
        if self.consent and not any(item.kind is ItemKind.AGREE for item in self.items):
            raise FormError(f"form '{self.name}' is a consent and has nothing to agree to: add an item of kind agree")

    @property
    def languages(self) -> tuple[str, ...]:
        """Languages in which every text is there, those of its title first to last."""
        texts = [self.title, *((self.intro,) if self.intro else ()), *(item.text for item in self.items)]
        texts += [words for item in self.items for _, words in item.options]
        texts += [w for i in self.items if i.scale for w in (i.scale.low_words, i.scale.high_words)]
        return tuple(code for code, _ in self.title.texts if all(code in text.languages for text in texts))
