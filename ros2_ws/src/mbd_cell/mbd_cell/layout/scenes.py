"""What a task is in the cell: its source and target sets, what is demonstrated and which mapping is right."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from mbd_model.objects import Role
from mbd_model.task import StepKind


class Shape(StrEnum):
    """Forms that can be laid on the table."""

    CUP = "cup"
    BOWL = "bowl"
    TRAY = "tray"
    BOX = "box"
    ELLIPSOID = "ellipsoid"
    UTENSIL = "utensil"


HOLLOW = frozenset({Shape.CUP, Shape.BOWL, Shape.TRAY})


@dataclass(frozen=True)
class ObjectSpec:
    """One object as the scene file describes it.

    Attributes:
        name: unique in its set.
        shape: its form.
        size: (x, y, z) of its bounding box in its own frame [m]; z is up. Cups and bowls: x = y = diameter of the rim.
        hue: HSV hue [deg, 0..360), None for grey.
        mass: [kg].
        upside_down: a cup standing on its rim.
        region: (x_min, x_max, y_min, y_max) its centre must lie in [m, robot base frame]; None: anywhere in reach.
    """

    name: str
    shape: Shape
    size: tuple[float, float, float]
    hue: float | None
    mass: float
    upside_down: bool = False
    region: tuple[float, float, float, float] | None = None

    @property
    def hollow(self) -> bool:
        """True when something can be put into it as it stands."""
        return self.shape in HOLLOW and not self.upside_down

    @property
    def footprint_radius(self) -> float:
        """Radius of the circle about its centre that holds its outline at any yaw [m]."""
        if self.shape in (Shape.CUP, Shape.BOWL):
            return 0.5 * self.size[0]
        return 0.5 * math.hypot(self.size[0], self.size[1])


@dataclass(frozen=True)
class DemonstratedStep:
    """One step the teacher shows.

    Attributes:
        kind: PICK or PLACE.
        picked: object in the hand at that step.
        onto: object placed onto or into, None for a PICK or a place on the table.
        position: PLACE with ``onto``: (x, y) from that object's centre in its frame; else on the table, robot base [m].
        turn: yaw of the placed object relative to ``onto`` (or to the base frame) [rad], of the hand
            if the object is round; None: as it comes.
    """

    kind: StepKind
    picked: str
    onto: str | None = None
    position: tuple[float, float] = (0.0, 0.0)
    turn: float | None = None


class Arrangement(StrEnum):
    """How objects are spread over the table.

    ROWS is how a study's experimenter lays them: two tidy rows, who stands where by chance. Source and target tables
    then look alike, and where objects stand suggests a mapping, most often a wrong one (as in the study's data).
    """

    SCATTERED = "scattered"
    ROWS = "rows"


@dataclass(frozen=True)
class TaskScenes:
    """A complete scene file.

    Attributes:
        task: its name.
        source, target: the objects of each set.
        steps: the demonstration, PICK and PLACE in turn.
        solution: source name -> target names that are right for it, in order of preference.
        arrangement: how either set is spread over the table.
        spares: further objects beside the table, out of sight, while the target set is on it; somebody may add them.
    """

    task: str
    source: tuple[ObjectSpec, ...]
    target: tuple[ObjectSpec, ...]
    steps: tuple[DemonstratedStep, ...]
    solution: Mapping[str, tuple[str, ...]]
    arrangement: Arrangement = Arrangement.SCATTERED
    spares: tuple[ObjectSpec, ...] = ()

    def objects(self, role: Role) -> tuple[ObjectSpec, ...]:
        """The set of that role, with the target set the spares behind it."""
        return self.source if role is Role.SOURCE else (*self.target, *self.spares)
