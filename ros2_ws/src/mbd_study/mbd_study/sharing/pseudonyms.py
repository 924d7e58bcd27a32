"""New names for participants and sessions, which do not tell the old ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SessionToShare:
    """What a new name is made of; ``start``: first log time [ns]; ``planned``: ``<condition>_<task>``, or ""."""

    session: str
    participant: str
    start: int
    planned: str = ""


def new_participants(participants: Sequence[str], rng: np.random.Generator) -> dict[str, str]:
    """A pseudonym for each, in an order that says nothing: a01, a02, ...; none is one of the old names.

    Args:
        participants: old pseudonyms.
        rng: of the order.
    """
    old = sorted(set(participants))
    width = max(2, len(str(len(old))))
    # Another letter where the study itself used this one; p, s and t are taken by participants and objects everywhere.
    used = {name.rstrip("0123456789") for name in old}
    letter = next(c for c in (*"abcdefghijklmnoqruvwxyz", "anon", "anonymous") if c not in used)
    places = rng.permutation(len(old))
    return {name: f"{letter}{number + 1:0{width}d}" for name, number in zip(old, places, strict=True)}


def new_sessions(sessions: Sequence[SessionToShare], participants: Mapping[str, str]) -> tuple[str, ...]:
    """A name for each session: its participant's, and what was planned, else its number in the participant's order.

    Args:
        sessions: in any order.
        participants: new pseudonym by old one.
    """
    order = sorted(range(len(sessions)), key=lambda k: sessions[k].start)
    counts: dict[str, int] = {}
    names = [""] * len(sessions)
    for place in order:
        one = sessions[place]
        counts[one.participant] = counts.get(one.participant, 0) + 1
        last = one.planned or f"{counts[one.participant]:02d}"
        name = f"{participants[one.participant]}_{last}"
        names[place] = name if name not in names else f"{name}_{counts[one.participant]:02d}"
    return tuple(names)
