"""The words of a command line as values: numbers within bounds, and places that have a name."""

from __future__ import annotations

import math
from argparse import ArgumentTypeError
from pathlib import Path


def whole_number(word: str) -> int:
    """A whole number from 0 on: seeds, and counts of what may be absent.

    Raises:
        ArgumentTypeError: it is no such number.
    """
    return _whole_from(0, word)


def at_least_one(word: str) -> int:
    """A whole number from 1 on; raises ArgumentTypeError."""
    return _whole_from(1, word)


def finite(word: str) -> float:
    """A finite number; raises ArgumentTypeError."""
    try:
        value = float(word)
    except ValueError:
        raise ArgumentTypeError(f"'{word}' is no number") from None
    if not math.isfinite(value):
        raise ArgumentTypeError(f"'{word}' is no finite number")
    return value


def zero_or_more(word: str) -> float:
    """A finite number from 0 on; raises ArgumentTypeError."""
    value = finite(word)
    if value < 0.0:
        raise ArgumentTypeError(f"{value:g} is negative; expected 0 or more")
    return value


def above_zero(word: str) -> float:
    """A finite number above 0; raises ArgumentTypeError."""
    value = finite(word)
    if value <= 0.0:
        raise ArgumentTypeError(f"{value:g} is not above 0")
    return value


def zero_to_one(word: str) -> float:
    """A number from 0 to 1, as probabilities and confidences are; raises ArgumentTypeError."""
    value = finite(word)
    if not 0.0 <= value <= 1.0:
        raise ArgumentTypeError(f"{value:g} is not from 0 to 1")
    return value


def named_place(word: str) -> Path:
    """A path; raises ArgumentTypeError for an empty word, which pathlib takes for the current folder."""
    if not word.strip():
        raise ArgumentTypeError("the path is empty (a shell variable that is not set?)")
    return Path(word)


def _whole_from(least: int, word: str) -> int:
    try:
        value = int(word)
    except ValueError:
        raise ArgumentTypeError(f"'{word}' is no whole number; expected {least} or more") from None
    if value < least:
        raise ArgumentTypeError(f"{value} is too few; expected {least} or more")
    return value
