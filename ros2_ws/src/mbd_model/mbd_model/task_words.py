"""A demonstrated task in words for people: which object is which, and each pick with its place as a sentence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from mbd_model.objects import Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep


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


def sentence(task: Task, carry: Carry) -> str:
    """One pick and place: "Pick the red bowl, put it onto the plate."."""
    names = names_in(task.source)
    if carry.place is None:
        return f"Pick the {names[carry.steps[0].primary_object]} (it is still held)."
    receiver = carry.place.primary_object
    if carry.pick is None:
        return f"Put what is held onto the {names[receiver]}."
    where = "put it down" if receiver == carry.pick.primary_object else f"put it onto the {names[receiver]}"
    return f"Pick the {names[carry.pick.primary_object]}, {where}."
