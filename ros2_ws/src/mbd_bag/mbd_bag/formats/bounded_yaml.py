"""YAML that came with a bag, read within bounds: no text of a few bytes takes the memory or the stack of a process.

PyYAML composes by recursion, so that a text nested deeply ends the process itself; and aliases of aliases stand for
more values than there is memory. Both show in the stream of events, which is read without recursion before anything
is made of it.
"""

from __future__ import annotations

from typing import Any

import yaml

LARGEST_TEXT = 16 << 20  # [characters]; a bag of a thousand files and topics has less than one million
DEEPEST = 50
MOST_VALUES = 500_000
# libyaml's where PyYAML has it: a study's bags are read 20 times faster.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_OPENS = (yaml.SequenceStartEvent, yaml.MappingStartEvent)
_CLOSES = (yaml.SequenceEndEvent, yaml.MappingEndEvent)


def bounded_yaml(text: str) -> Any:
    """The value that a YAML text states.

    Args:
        text: of one document.

    Raises:
        ValueError: it is no YAML, or too long, too deep, or stands for too many values.
    """
    if len(text) > LARGEST_TEXT:
        raise ValueError(f"its {len(text)} characters are more than the {LARGEST_TEXT} expected at most")
    try:
        _measure(text)
        return yaml.load(text, _LOADER)
    except (yaml.YAMLError, RecursionError, OverflowError, TypeError, AttributeError, KeyError) as error:
        # The reader calls every text by this name, which means nothing to who gave a file.
        why = " ".join(str(error).split()).replace('in "<unicode string>", line', "at line")
        raise ValueError(why or type(error).__name__) from error


def _measure(text: str) -> None:
    """Raises ValueError when a text is nested too deeply or stands for too many values."""
    sizes: dict[str, int] = {}
    # Of each collection that is open: its anchor, and how many values it stands for so far.
    opened: list[tuple[str | None, int]] = []
    total = 0
    for event in yaml.parse(text, _LOADER):
        size = 1
        anchor = getattr(event, "anchor", None)
        if isinstance(event, _OPENS):
            opened.append((anchor, 1))
            if len(opened) > DEEPEST:
                raise ValueError(f"it is nested deeper than {DEEPEST} levels")
            continue
        if isinstance(event, _CLOSES):
            anchor, size = opened.pop()
        elif isinstance(event, yaml.AliasEvent):
            if anchor not in sizes:
                raise ValueError(f"it refers to itself by *{anchor}")
            size = sizes[anchor]
        elif not isinstance(event, yaml.ScalarEvent):
            continue
        if anchor is not None:
            sizes[anchor] = size
        total += size
        if max(total, size) > MOST_VALUES:
            raise ValueError(f"it stands for more than {MOST_VALUES} values")
        if opened:
            opened[-1] = (opened[-1][0], opened[-1][1] + size)
