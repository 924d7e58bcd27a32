"""What an object is and affords, by its size and hue: the knowledge base (paper sec. 4.1, Tables 2 and 4)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from mbd_model.errors import MbdError

UNKNOWN = "unknown"
SIZE_KEYS = ("long", "short", "height")
RATIO_KEYS = ("short_to_long", "height_to_long", "height_to_short")
SET_KEYS = ("affordances", "properties")


class KnowledgeError(MbdError):
    """A knowledge base that cannot be used; the text names file and key."""


@dataclass(frozen=True)
class ObjectClass:
    """One class of objects.

    Attributes:
        name: its name.
        affordances, properties: what all its members afford and are.
        ranges: (lowest, highest) by key: long and short horizontal side and height [m], and their ratios.
        hue: (from, to) [deg], counted upwards, so (340, 20) goes through red; None when any hue, or none, will do.
    """

    name: str
    affordances: frozenset[str]
    properties: frozenset[str]
    ranges: Mapping[str, tuple[float, float]]
    hue: tuple[float, float] | None = None


@dataclass(frozen=True)
class ClassMatch:
    """The class an object was given.

    Attributes:
        object_class: the class; None when unknown.
        score: how well it fits, 0..1; for an unknown object that of the best class.
    """

    object_class: ObjectClass | None
    score: float

    @property
    def name(self) -> str:
        """The class's name, or "unknown"."""
        return UNKNOWN if self.object_class is None else self.object_class.name


@dataclass(frozen=True)
class KnowledgeBase:
    """Classes, and when to admit not knowing.

    Attributes:
        classes: in file order.
        size_tolerance: how far a measured length may lie outside its range [m] before it counts as half a fit.
        ratio_tolerance: the same for a ratio, as a share of the range's end.
        hue_tolerance: the same for hue [deg].
        min_score: a best class below this is no match.
        min_margin: a best class less than this ahead of the next is no match.
    """

    classes: tuple[ObjectClass, ...]
    size_tolerance: float = 0.006
    ratio_tolerance: float = 0.15
    hue_tolerance: float = 12.0
    min_score: float = 0.5
    min_margin: float = 0.02

    def match(self, size: tuple[float, float, float], hue: float | None) -> ClassMatch:
        """The class that fits best, or unknown.

        Args:
            size: (width, depth, height) [m]; which side is called width does not matter.
            hue: [deg], None for a grey object.
        """
        scores = [(self.score(c, size, hue), i) for i, c in enumerate(self.classes)]
        scored = sorted(scores, key=lambda s: (-s[0], s[1]))
        if not scored:
            return ClassMatch(None, 0.0)
        best, index = scored[0]
        runner_up = scored[1][0] if len(scored) > 1 else 0.0
        if best < self.min_score or best - runner_up < self.min_margin:
            return ClassMatch(None, best)
        return ClassMatch(self.classes[index], best)

    def score(self, candidate: ObjectClass, size: tuple[float, float, float], hue: float | None) -> float:
        """How well a class fits, 0..1.

        An object in the middle of every range scores 1, one at their ends 0.8; each key that lies one tolerance
        outside its range halves that, two tolerances leave a sixteenth.
        """
        long, short, height = max(size[:2]), min(size[:2]), size[2]
        measured = {
            "long": long,
            "short": short,
            "height": height,
            "short_to_long": short / long,
            "height_to_long": height / long,
            "height_to_short": height / short,
        }
        fit, centred = 1.0, 0.0
        for key, (low, high) in candidate.ranges.items():
            value = measured[key]
            excess = max(low - value, value - high, 0.0)
            end = low if value < low else high
            tolerance = self.size_tolerance if key in SIZE_KEYS else self.ratio_tolerance * end
            fit *= 0.5 ** ((excess / tolerance) ** 2)
            centred += 1.0 if high <= low else 1.0 - min(abs(value - 0.5 * (low + high)) / (0.5 * (high - low)), 1.0)
        if candidate.hue is not None:
            fit *= 0.0 if hue is None else 0.5 ** ((_hue_excess(hue, candidate.hue) / self.hue_tolerance) ** 2)
        return fit * (0.8 + 0.2 * centred / len(candidate.ranges))


def _hue_excess(hue: float, allowed: tuple[float, float]) -> float:
    """How far a hue lies outside the arc that goes upwards from the first to the second angle [deg]."""
    start, stop = allowed
    span = (stop - start) % 360.0
    along = (hue - start) % 360.0
    return 0.0 if along <= span else min(along - span, 360.0 - along)


def load_knowledge(path: Path) -> KnowledgeBase:
    """Read a knowledge base from YAML.

    Raises:
        KnowledgeError: not readable, or a key that is missing, unknown or out of range; names the file and the key.
    """
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise KnowledgeError(f"{path}: cannot be read ({error.strerror}); give the path of a knowledge base") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise KnowledgeError(f"{path}: is not YAML ({error})") from error
    return parse_knowledge(document, str(path))


def parse_knowledge(document: Any, source: str) -> KnowledgeBase:
    """A knowledge base from parsed YAML; ``source`` names it in errors. Raises KnowledgeError naming the key."""
    if not isinstance(document, dict):
        raise KnowledgeError(f"{source}: expected a mapping with the key 'classes', found {type(document).__name__}")
    numbers = ("size_tolerance", "ratio_tolerance", "hue_tolerance", "min_score", "min_margin")
    _refuse_others(document, ("classes", *numbers), source, "")
    classes = document.get("classes")
    if not isinstance(classes, dict) or not classes:
        raise KnowledgeError(f"{source}: 'classes' must map at least one class name to its description")
    settings = {key: _number(document[key], source, key) for key in numbers if key in document}
    for key in ("size_tolerance", "ratio_tolerance", "hue_tolerance"):
        if settings.get(key, 1.0) <= 0:
            raise KnowledgeError(f"{source}: '{key}' is {settings[key]}, expected a positive number")
    return KnowledgeBase(tuple(_parse_class(str(n), d, source) for n, d in classes.items()), **settings)


def _parse_class(name: str, document: Any, source: str) -> ObjectClass:
    """One class; raises KnowledgeError naming the key."""
    where = f"classes.{name}"
    if name == UNKNOWN:
        raise KnowledgeError(f"{source}: '{where}': 'unknown' is what an object without a class is called; rename it")
    if not isinstance(document, dict):
        raise KnowledgeError(f"{source}: '{where}' must be a mapping, found {type(document).__name__}")
    _refuse_others(document, (*SIZE_KEYS, *RATIO_KEYS, *SET_KEYS, "hue"), source, where + ".")
    for key in SIZE_KEYS:
        if key not in document:
            raise KnowledgeError(f"{source}: '{where}.{key}' is missing: give [lowest, highest] in metres")
    ranges = {key: _range(document[key], source, f"{where}.{key}") for key in SIZE_KEYS + RATIO_KEYS if key in document}
    sets = {key: _words(document.get(key, []), source, f"{where}.{key}") for key in SET_KEYS}
    hue = None
    if "hue" in document:
        hue = _pair(document["hue"], source, f"{where}.hue")
        if not all(0 <= h <= 360 for h in hue):
            raise KnowledgeError(f"{source}: '{where}.hue' {list(hue)} is outside 0..360 degrees")
    return ObjectClass(name, sets["affordances"], sets["properties"], ranges, hue)


def _refuse_others(document: Mapping[Any, Any], known: tuple[str, ...], source: str, where: str) -> None:
    """Raises KnowledgeError for a key nobody reads: a misspelt one must not be ignored."""
    for key in document:
        if key not in known:
            raise KnowledgeError(f"{source}: '{where}{key}' is not known here; the keys are {', '.join(known)}")


def _number(value: Any, source: str, where: str) -> float:
    """A finite number; raises KnowledgeError."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise KnowledgeError(f"{source}: '{where}' is {value!r}, expected a number")
    return float(value)


def _pair(value: Any, source: str, where: str) -> tuple[float, float]:
    """Two numbers; raises KnowledgeError."""
    if not isinstance(value, list) or len(value) != 2:
        raise KnowledgeError(f"{source}: '{where}' is {value!r}, expected [lowest, highest]")
    return _number(value[0], source, where), _number(value[1], source, where)


def _range(value: Any, source: str, where: str) -> tuple[float, float]:
    """A range of positive numbers; raises KnowledgeError."""
    low, high = _pair(value, source, where)
    if not 0 < low <= high:
        raise KnowledgeError(f"{source}: '{where}' [{low}, {high}] must be positive, the lower number first")
    return low, high


def _words(value: Any, source: str, where: str) -> frozenset[str]:
    """A list of words; raises KnowledgeError."""
    if not isinstance(value, list) or not all(isinstance(w, str) and w for w in value):
        raise KnowledgeError(f"{source}: '{where}' is {value!r}, expected a list of words")
    return frozenset(value)
