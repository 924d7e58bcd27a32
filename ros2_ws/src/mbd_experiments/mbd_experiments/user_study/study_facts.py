"""What a session's bag states of the study it belongs to, for the experiments: facts ``study.*`` beside the usual ones.

``study.origin`` is "real" (the paper's study), "own" (one's own) or "simulated"; ``study.script`` the (picked, placed
onto) objects that the experimenter asked for, by true name: ``milk>box pear>box``; ``study.intended`` what a simulated
participant was to get wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum

from mbd_bag.errors import BagError

ORIGIN, SCRIPT, INTENDED = "study.origin", "study.script", "study.intended"
Pairs = tuple[tuple[str, str], ...]


class Origin(StrEnum):
    """Where sessions come from; every caption states it."""

    REAL = "real"
    OWN = "own"
    SIMULATED = "simulated"

    @property
    def words(self) -> str:
        """For a caption."""
        if self is Origin.REAL:
            return "real data: recorded features and assists of the 2017 user study"
        if self is Origin.OWN:
            return "real data: sessions recorded with this project"
        return "simulated data: scripted participants in the simulated cell"


# What each task of the user study asks for (paper sec. 6): the object picked and the one it is placed onto.
TASK_NAMES = ("stacking", "sorting", "lunch_packing")
REAL_SCRIPTS: Mapping[str, Pairs] = {
    "stacking": tuple((cup, "yellow_cup") for cup in ("blue_cup", "purple_cup", "green_cup", "orange_cup")),
    "sorting": tuple((f"small_{hue}", f"large_{hue}") for hue in ("orange", "green", "blue")),
    "lunch_packing": tuple((thing, "box") for thing in ("milk", "pear", "chips")),
}


def script_text(pairs: Iterable[tuple[str, str]]) -> str:
    """A script as a fact."""
    return " ".join(f"{picked}>{onto}" for picked, onto in pairs)


def script_from(facts: Mapping[str, str]) -> Pairs:
    """The script in a bag's facts, () when there is none; raises BagError for one that cannot be read."""
    pairs = []
    for word in facts.get(SCRIPT, "").split():
        picked, sign, onto = word.partition(">")
        if not (picked and sign and onto):
            raise BagError(f"fact {SCRIPT} holds '{word}'; expected words such as small_red>large_red")
        pairs.append((picked, onto))
    return tuple(pairs)
