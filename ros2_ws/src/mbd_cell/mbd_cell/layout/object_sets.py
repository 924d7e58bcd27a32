"""Sets of objects newly drawn: other sizes, hues and shapes than a scene file's, within the sense of its task.

What decides the right mapping of a task stays (docs/object_catalogue.md): sizes fall in steps where size decides, hues
agree where hue decides, classes stay classes. All else is drawn: the sizes within what the hand spans and what fits
into what, the proportions within a class, the hues, of sorting also the shape of the target set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.objects import Role

from mbd_cell.layout.scenes import ObjectSpec, Shape, TaskScenes

SET_STREAM = 21  # of chance, apart from those of layouts, the teacher and the camera
Objects = dict[str, ObjectSpec]
Solution = Mapping[str, tuple[str, ...]]


def drawn_scenes(scenes: TaskScenes, seed: int) -> TaskScenes:
    """The task with source and target objects newly drawn, names, steps and solution kept: a function of its arguments.

    Raises:
        MbdError: nothing is known about what the task's objects may be like.
    """
    if scenes.task not in _DRAWERS:
        raise MbdError(f"no object sets can be drawn for task '{scenes.task}'; there are rules for {sorted(_DRAWERS)}")
    rng = np.random.default_rng([seed, SET_STREAM])
    source, target = ({o.name: o for o in scenes.objects(role)} for role in (Role.SOURCE, Role.TARGET))
    _DRAWERS[scenes.task](source, target, scenes.solution, rng)
    return _with_scaled_offsets(scenes, replace(scenes, source=tuple(source.values()), target=tuple(target.values())))


def _with_scaled_offsets(before: TaskScenes, after: TaskScenes) -> TaskScenes:
    """Offsets of the steps in proportion to the objects they are on."""
    old, new = ({o.name: o.size for o in scenes.source} for scenes in (before, after))
    steps = tuple(
        step
        if step.onto is None
        else replace(
            step,
            position=(
                step.position[0] * new[step.onto][0] / old[step.onto][0],
                step.position[1] * new[step.onto][1] / old[step.onto][1],
            ),
        )
        for step in before.steps
    )
    return replace(after, steps=steps)


def _resized(thing: ObjectSpec, size: tuple[float, float, float], hue: float) -> ObjectSpec:
    """That object with another size [m] and hue [deg], its mass in proportion to its surface."""
    x, y, z = (round(v, 4) for v in size)
    grown = (x * y * z / float(np.prod(thing.size))) ** (2 / 3)
    return replace(thing, size=(x, y, z), hue=round(hue % 360.0, 1), mass=round(thing.mass * grown, 4))


def _round(
    thing: ObjectSpec, diameter: float, rng: np.random.Generator, hue: float, shape: Shape | None = None
) -> ObjectSpec:
    """A cup or bowl of that rim [m]; its proportions are drawn within its class."""
    shape = shape or thing.shape
    low, high = (0.40, 0.44) if shape is Shape.BOWL else (1.20, 1.30)
    return replace(
        _resized(thing, (diameter, diameter, diameter * float(rng.uniform(low, high))), hue),
        shape=shape,
        mass=round(0.2 if shape is Shape.BOWL else 0.04 + 0.35 * diameter, 4),
    )


def _hues(count: int, rng: np.random.Generator) -> list[float]:
    """Hues [deg] all round the circle, from a random one on, in random order."""
    step = 360.0 / count
    start = float(rng.uniform(0.0, 360.0))
    return [start + step * int(k) + float(rng.uniform(-0.2, 0.2)) * step for k in rng.permutation(count)]


def _stacking(source: Objects, target: Objects, _: Solution, rng: np.random.Generator) -> None:
    """Five sizes that fall in equal ratios."""
    for objects in (source, target):
        largest, smallest = float(rng.uniform(0.074, 0.080)), float(rng.uniform(0.039, 0.042))
        diameters = np.geomspace(largest, smallest, len(objects))
        for (name, thing), diameter, hue in zip(
            list(objects.items()), diameters, _hues(len(objects), rng), strict=True
        ):
            objects[name] = _round(thing, float(diameter), rng, hue)


def _sorting(source: Objects, target: Objects, solution: Solution, rng: np.random.Generator) -> None:
    """A hue for each colour, nearly the same in both sets; small ones that go into large ones."""
    colours = dict(zip(("red", "green", "blue"), sorted(_hues(3, rng)), strict=True))
    large = float(rng.uniform(0.071, 0.079))
    widths = {"small": large * float(rng.uniform(0.63, 0.69)), "large": large}
    for name, thing in list(source.items()):
        which, colour = name.split("_")
        source[name] = _round(thing, widths[which], rng, colours[colour])
    cups = bool(rng.integers(2))
    rims = (
        (large * float(rng.uniform(0.63, 0.69)), large)
        if cups
        else (float(rng.uniform(0.107, 0.112)), float(rng.uniform(0.127, 0.134)))
    )
    shift = float(rng.uniform(-10.0, 10.0))
    for name, thing in list(target.items()):
        colour, size = name.split("_")
        hue = colours[colour] + shift + float(rng.uniform(-3.0, 3.0))
        target[name] = _round(thing, rims[int(size) - 1], rng, hue, Shape.CUP if cups else Shape.BOWL)


def _lunch_packing(source: Objects, target: Objects, _: Solution, rng: np.random.Generator) -> None:
    """A carton, an open box, a fruit and a packet in each set, of any hue but for the fruit."""
    for objects in (source, target):
        for (name, thing), hue in zip(list(objects.items()), _hues(len(objects), rng), strict=True):
            if thing.shape is Shape.TRAY:
                size = (rng.uniform(0.232, 0.255), rng.uniform(0.17, 0.188), rng.uniform(0.05, 0.058))
            elif thing.shape is Shape.ELLIPSOID:
                long = rng.uniform(0.060, 0.075)
                size = (long, long * rng.uniform(0.90, 1.0), long * rng.uniform(0.77, 0.83))
            elif thing.size[0] == thing.size[1]:
                side = rng.uniform(0.053, 0.061)
                size = (side, side, side * rng.uniform(1.93, 2.07))
            else:
                long = rng.uniform(0.086, 0.099)
                short = long * rng.uniform(0.465, 0.49)
                size = (long, short, short * rng.uniform(1.93, 2.06))
            ripe = float(rng.uniform(65.0, 105.0))
            drawn = ripe if thing.shape is Shape.ELLIPSOID else hue
            objects[name] = _resized(thing, (float(size[0]), float(size[1]), float(size[2])), drawn)


def _assembly(source: Objects, target: Objects, solution: Solution, rng: np.random.Generator) -> None:
    """Large and small blocks; six hues, shifted a little in the target set."""
    turn, shift = float(rng.uniform(0.0, 360.0)), float(rng.uniform(-10.0, 10.0))
    long = float(rng.uniform(0.078, 0.086))
    for objects, scale in ((source, 1.0), (target, float(rng.uniform(0.94, 1.12)))):
        small, flat, low = (
            float(rng.uniform(0.69, 0.74)),
            float(rng.uniform(0.60, 0.64)),
            float(rng.uniform(0.72, 0.78)),
        )
        base = 0.9 * max(o.size[0] for o in objects.values())
        for name, thing in list(objects.items()):
            side = long * scale * (1.0 if thing.size[0] > base else small)
            if objects is source:
                hue = float(thing.hue or 0.0) + turn + float(rng.uniform(-4.0, 4.0))
            else:
                hue = float(next(source[s].hue or 0.0 for s, right in solution.items() if name in right)) + shift
            objects[name] = _resized(thing, (side, side * flat, side * flat * low), hue)


def _dish_sorting(source: Objects, target: Objects, _: Solution, rng: np.random.Generator) -> None:
    """Two utensils, two cups of which one goes into the other, three bowls; any hue."""
    for objects in (source, target):
        large = float(rng.uniform(0.071, 0.078))
        cups = [large * float(rng.uniform(0.64, 0.69)), large]
        bowls = [float(rng.uniform(a, a + 0.004)) for a in (0.107, 0.118, 0.129)]
        lengths = sorted(float(rng.uniform(a, a + 0.01)) for a in (0.142, 0.157))
        for (name, thing), hue in zip(list(objects.items()), _hues(len(objects), rng), strict=True):
            if thing.shape is Shape.UTENSIL:
                width = float(rng.uniform(0.019, 0.023))
                objects[name] = _resized(thing, (lengths.pop(0), width, width * float(rng.uniform(0.78, 0.85))), hue)
            else:
                objects[name] = _round(thing, (bowls if thing.shape is Shape.BOWL else cups).pop(0), rng, hue)


_Drawer = Callable[[Objects, Objects, Solution, np.random.Generator], None]
_DRAWERS: dict[str, _Drawer] = {
    "stacking": _stacking,
    "sorting": _sorting,
    "lunch_packing": _lunch_packing,
    "assembly": _assembly,
    "dish_sorting": _dish_sorting,
}
