"""A demonstrated task for people: what each object is called, and its steps as picks with their places."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from mbd_model.objects import Scene, SceneObject
from mbd_model.task import StepKind, TaskStep


def described(thing: SceneObject) -> str:
    """An object in words: "blue cup"."""
    words = [thing.color_name, "" if thing.object_class == "unknown" else thing.object_class.replace("_", " ")]
    return " ".join(w for w in words if w) or "object"


def names_in(scene: Scene) -> dict[str, str]:
    """What to call each object of a scene, by id: "red cup"; with its id where others look alike: "red cup s2"."""
    words = {thing.object_id: described(thing) for thing in scene.objects}
    alike = Counter(words.values())
    return {i: f"{text} {i}" if alike[text] > 1 or text == "object" else text for i, text in words.items()}


@dataclass(frozen=True)
class Carry:
    """A PICK with the PLACE after it, either of which may lack.

    Attributes:
        first, last: 0-based numbers of its steps; the same where one lacks.
        pick, place: the steps; None where one lacks.
    """

    first: int
    last: int
    pick: TaskStep | None
    place: TaskStep | None

    @property
    def steps(self) -> tuple[TaskStep, ...]:
        """Those it has, in order."""
        return tuple(s for s in (self.pick, self.place) if s is not None)


def carries(steps: Sequence[TaskStep]) -> tuple[Carry, ...]:
    """The steps of a task as picks with their places, in order."""
    found: list[Carry] = []
    held: int | None = None
    for number, step in enumerate(steps):
        if step.kind is StepKind.PICK:
            if held is not None:
                found.append(Carry(held, held, steps[held], None))
            held = number
        else:
            found.append(Carry(number if held is None else held, number, None if held is None else steps[held], step))
            held = None
    if held is not None:
        found.append(Carry(held, held, steps[held], None))
    return tuple(found)
