"""Names as BIDS allows them: letters and digits only, and no two names the same label."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping


def labels(names: Iterable[str], nothing: str) -> Mapping[str, str]:
    """A label for each name: its letters and digits, with a number behind where two would have the same.

    Args:
        names: in the order that they shall be numbered in; one may come again.
        nothing: label of a name without letters and digits.
    """
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in dict.fromkeys(names):
        plain = re.sub(r"[^A-Za-z0-9]", "", name) or nothing
        label, number = plain, 1
        # Where file names do not tell capitals from small letters, labels must not either.
        while label.lower() in taken:
            number += 1
            label = f"{plain}x{number}"
        taken.add(label.lower())
        found[name] = label
    return found
