"""Whether an object ended where the demonstration put the one it stands for: judged by true poses only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mbd_model.task import StepKind

from mbd_cell.arm.grasp_planning import yaw_of
from mbd_cell.layout.scenes import DemonstratedStep
from mbd_cell.physics.simulation import Pose, Simulation

# An object stands on another when its bottom is this near to the other's top [m]; lower it is in it.
STANDING = 0.012
# It stands upright when its axis leans less than this [rad]; in a bowl it may lean more.
LEANING = math.radians(15.0)
# A place on the table is reached within this [m].
PLACE = 0.03
# Where on or in the other it is may differ from the demonstrated place by this share of the other's half size.
SHARE = 0.5


@dataclass(frozen=True)
class ObjectState:
    """An object as it is.

    Attributes:
        pose: of the centre of its box.
        size: (x, y, z) of its box in its own frame [m].
    """

    pose: Pose
    size: tuple[float, float, float]

    @property
    def bottom(self) -> float:
        """Height of its bottom [m] if it is upright."""
        return self.pose.position[2] - self.size[2] / 2

    @property
    def top(self) -> float:
        """Height of its top [m] if it is upright."""
        return self.pose.position[2] + self.size[2] / 2

    @property
    def lean(self) -> float:
        """How far its axis is off the vertical [rad]."""
        x, y, _, _ = self.pose.quaternion
        return math.acos(max(-1.0, min(1.0, 1 - 2 * (x * x + y * y))))


def object_states(simulation: Simulation) -> dict[str, ObjectState]:
    """Every object of a table as it is, by name."""
    return {name: ObjectState(simulation.object_pose(name), o.size) for name, o in simulation.objects.items()}


@dataclass(frozen=True)
class PlaceOutcome:
    """What became of one place step.

    Attributes:
        step: its index.
        held, onto: the target objects; None: the table.
        success: the object is where it should be.
        why: why not.
    """

    step: int
    held: str
    onto: str | None
    success: bool
    why: str = ""


def outcomes(
    steps: Sequence[DemonstratedStep],
    source: Mapping[str, ObjectState],
    target: Mapping[str, ObjectState],
    mapping: Mapping[str, str],
) -> tuple[PlaceOutcome, ...]:
    """What became of each place step.

    Args:
        steps: what was demonstrated.
        source: the source objects after the demonstration.
        target: the target objects after the robot executed the task.
        mapping: source name -> target name.

    Returns:
        One for each PLACE, in order. A step whose objects the mapping leaves out has failed.
    """
    found = []
    for index, step in enumerate(steps):
        if step.kind is not StepKind.PLACE:
            continue
        held = mapping.get(step.picked, "")
        onto = mapping.get(step.onto, "") if step.onto is not None else None
        if held not in target or (onto is not None and onto not in target):
            why = "an object it needs has no counterpart"
        elif onto is None or step.onto is None:
            why = _beside_place(step, target[held])
        else:
            why = _off(source[step.picked], source[step.onto], target[held], target[onto])
        found.append(PlaceOutcome(index, held, onto, not why, why))
    return tuple(found)


def _beside_place(step: DemonstratedStep, held: ObjectState) -> str:
    apart = math.dist(held.pose.position[:2], step.position)
    return f"{apart * 100:.0f} cm from its place on the table" if apart > PLACE else ""


def _off(shown_held: ObjectState, shown_onto: ObjectState, held: ObjectState, onto: ObjectState) -> str:
    """Why the held object is not on (or in) the other as demonstrated; "" when it is."""
    shown, now = _place_on(shown_held, shown_onto), _place_on(held, onto)
    # The frame of a box means the same after half a turn.
    off = min(math.dist(shown, now), math.dist((-shown[0], -shown[1]), now))
    if off > SHARE:
        return f"its middle is {off:.1f} half sizes off the demonstrated place"
    inside = shown_onto.top - shown_held.bottom > STANDING
    if inside and held.bottom > onto.top - 0.003 and _fits(held, onto):
        return "it is on top and not inside"
    if held.bottom < onto.bottom - 0.003:
        return "it lies below"
    if not inside and abs(held.bottom - onto.top) > STANDING and _same_kind(shown_held, held):
        return f"its bottom is {1000 * (held.bottom - onto.top):.0f} mm off the other's top"
    if not inside and held.lean > LEANING + shown_held.lean:
        return f"it leans by {math.degrees(held.lean):.0f} degrees"
    return ""


def _place_on(held: ObjectState, onto: ObjectState) -> tuple[float, float]:
    """Where the held object's middle is in the other's frame, in half sizes of it."""
    dx = held.pose.position[0] - onto.pose.position[0]
    dy = held.pose.position[1] - onto.pose.position[1]
    yaw = yaw_of(onto.pose)
    c, s = math.cos(yaw), math.sin(yaw)
    return (c * dx + s * dy) / (onto.size[0] / 2), (c * dy - s * dx) / (onto.size[1] / 2)


def _fits(held: ObjectState, onto: ObjectState) -> bool:
    return min(held.size[:2]) < min(onto.size[:2])


def _same_kind(shown: ObjectState, now: ObjectState) -> bool:
    """Upright both times; what lies tilted over a rim has no bottom to compare."""
    return shown.lean < LEANING and now.lean < LEANING
