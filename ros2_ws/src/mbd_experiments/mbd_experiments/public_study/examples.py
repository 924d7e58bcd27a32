"""Small examples: the one of docs/mapping.md by hand, and one for each way in which scenes may not match one to one."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_model.assists import Assist
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

HUES = {"red": 5.0, "green": 120.0, "blue": 240.0}


@dataclass(frozen=True)
class Example:
    """A task, a target scene and assists to try.

    Attributes:
        about: what it shows.
        task, target, assists: the arguments of ``inference.infer``.
    """

    about: str
    task: Task
    target: Scene
    assists: tuple[Assist, ...] = ()


def cups(role: Role, *colors: str) -> Scene:
    """Equal cups of these colours, in no relation to each other."""
    return Scene(role, tuple(SceneObject(c, (0.5, 0.0, 0.05), (0.08, 0.08, 0.1), hue=HUES[c]) for c in colors))


def task_over(source: Scene, *used: str) -> Task:
    """A task that picks these objects in turn."""
    return Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(used)))


def by_hand() -> Example:
    """Three cups, three more, and one assist: the example of docs/mapping.md."""

    def cup(name: str, hue: float, volume: float) -> SceneObject:
        return SceneObject(name, (0.5, 0.0, 0.05), (0.08, 0.08, 0.1), hue=hue, volume=volume)

    source = Scene(Role.SOURCE, (cup("red", 0.0, 2e-4), cup("green", 120.0, 4e-4), cup("blue", 240.0, 8e-4)))
    target = Scene(Role.TARGET, (cup("A", 110.0, 8e-4), cup("B", 230.0, 2e-4), cup("C", 350.0, 4e-4)))
    return Example("three cups and three others", task_over(source, *source.ids), target, (Assist("red", "C"),))


def distractor() -> Example:
    """A blue cup that nobody demonstrated with stays unmapped."""
    source = cups(Role.SOURCE, "red", "green")
    target = cups(Role.TARGET, "blue", "green", "red")
    return Example("a blue cup too many in the target scene", task_over(source, "red", "green"), target)


def missing() -> Example:
    """Nothing in the target scene is left for the blue cup, and it stays unmapped."""
    source = cups(Role.SOURCE, "red", "green", "blue")
    target = cups(Role.TARGET, "green", "red")
    return Example("no blue cup in the target scene", task_over(source, "red", "green", "blue"), target)


def unused() -> Example:
    """The green cup, which the task never uses, still takes the green one, and is never asked about."""
    source = cups(Role.SOURCE, "red", "green", "blue")
    target = cups(Role.TARGET, "blue", "green", "red")
    return Example("a green cup the task never uses", task_over(source, "red", "blue"), target)


def shared() -> Example:
    """Placed onto twice, the blue cup is one object with one counterpart, and one assist settles it."""
    source = cups(Role.SOURCE, "red", "green", "blue")
    target = cups(Role.TARGET, "blue", "green", "red")
    task = task_over(source, "red", "blue", "green", "blue")
    return Example("two steps on the blue cup", task, target, (Assist("blue", "blue", 1),))


EXAMPLES = {
    "by_hand": by_hand,
    "distractor": distractor,
    "missing": missing,
    "unused": unused,
    "shared": shared,
}
