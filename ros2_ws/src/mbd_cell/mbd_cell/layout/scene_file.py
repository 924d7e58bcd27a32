"""Scenes as data: one YAML file a task (``config/stacking.yaml`` and its fellows), read and validated.

Lengths in metres, hues and turns in degrees, masses in kilograms.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import yaml
from mbd_model.errors import MbdError
from mbd_model.task import StepKind

from mbd_cell.layout.scenes import Arrangement, DemonstratedStep, ObjectSpec, Shape, TaskScenes

# Files beside the scenes that are none: parameters.
NO_SCENES = ("camera", "workspace")


class SceneFileError(MbdError):
    """A scene file that cannot be used; the text names the file and the key."""


def load_scenes(path: Path) -> TaskScenes:
    """Read and validate one scene file.

    Raises:
        SceneFileError: the file is missing, no YAML, or a value cannot be used; names the file and the key.
    """
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        known = sorted(p.stem for p in path.parent.glob("*.yaml") if p.stem not in NO_SCENES)
        raise SceneFileError(f"cannot read scene file {path} ({error.strerror}); tasks there: {known}") from error
    except yaml.YAMLError as error:
        raise SceneFileError(f"{path} is not valid YAML: {error}") from error
    return parse_scenes(document, str(path))


def parse_scenes(document: object, name: str) -> TaskScenes:
    """Validate a parsed scene document; ``name`` is what errors call it.

    Raises:
        SceneFileError: a value cannot be used; names the file and the key.
    """
    top = _mapping(document, name, "(top)", {"task", "arrangement", "source", "target", "steps", "solution"})
    task = _text(top.get("task"), name, "task")
    try:
        arrangement = Arrangement(str(top.get("arrangement", Arrangement.SCATTERED)))
    except ValueError:
        raise SceneFileError(
            f"{name}: arrangement: {top['arrangement']!r} is none of {[*map(str, Arrangement)]}"
        ) from None
    source = _objects(top.get("source"), name, "source")
    target = _objects(top.get("target"), name, "target")
    steps = _steps(top.get("steps"), name, {o.name for o in source})
    solution = _solution(top.get("solution"), name, source, target)
    used = {s.picked for s in steps} | {s.onto for s in steps if s.onto is not None}
    if missing := sorted(used - set(solution)):
        raise SceneFileError(f"{name}: solution: {missing} are demonstrated but have no right target; add them")
    return TaskScenes(task, source, target, steps, solution, arrangement)


def _objects(value: object, name: str, key: str) -> tuple[ObjectSpec, ...]:
    entries = _sequence(value, name, key)
    if not entries:
        raise SceneFileError(f"{name}: {key}: needs at least one object")
    objects = tuple(_object(entry, name, f"{key}[{i}]") for i, entry in enumerate(entries))
    names = [o.name for o in objects]
    if twice := sorted({n for n in names if names.count(n) > 1}):
        raise SceneFileError(f"{name}: {key}: {twice} name several objects; names must be unique in a set")
    return objects


def _object(value: object, name: str, key: str) -> ObjectSpec:
    entry = _mapping(value, name, key, {"name", "shape", "size", "hue", "mass", "upside_down", "region"})
    object_name = _text(entry.get("name"), name, f"{key}.name")
    key = f"{key} ({object_name})"
    try:
        shape = Shape(str(entry.get("shape")))
    except ValueError:
        raise SceneFileError(f"{name}: {key}.shape: {entry.get('shape')!r} is none of {[*map(str, Shape)]}") from None
    size = _numbers(entry.get("size"), name, f"{key}.size", 3)
    if not all(0.005 <= v <= 0.5 for v in size):
        raise SceneFileError(f"{name}: {key}.size: {list(size)} must lie in 0.005..0.5 [m]")
    if shape in (Shape.CUP, Shape.BOWL) and size[0] != size[1]:
        raise SceneFileError(f"{name}: {key}.size: a {shape} is round, so x and y must be equal; got {list(size)}")
    hue = entry.get("hue")
    if hue is not None:
        hue = _number(hue, name, f"{key}.hue")
        if not 0.0 <= hue < 360.0:
            raise SceneFileError(f"{name}: {key}.hue: {hue} is outside [0, 360) deg; leave it out for grey")
    mass = _number(entry.get("mass"), name, f"{key}.mass")
    if not 0.005 <= mass <= 2.0:
        raise SceneFileError(f"{name}: {key}.mass: {mass} must lie in 0.005..2 [kg]")
    upside_down = entry.get("upside_down", False)
    if not isinstance(upside_down, bool) or (upside_down and shape is not Shape.CUP):
        raise SceneFileError(f"{name}: {key}.upside_down: must be true or false, and true only for a cup")
    region = entry.get("region")
    box = None if region is None else _numbers(region, name, f"{key}.region", 4)
    if box is not None and not (box[0] < box[1] and box[2] < box[3]):
        raise SceneFileError(f"{name}: {key}.region: {list(box)} must be [x_min, x_max, y_min, y_max] [m]")
    return ObjectSpec(
        object_name, shape, (size[0], size[1], size[2]), hue, mass, upside_down,
        None if box is None else (box[0], box[1], box[2], box[3]),
    )  # fmt: skip


def _steps(value: object, name: str, known: set[str]) -> tuple[DemonstratedStep, ...]:
    steps: list[DemonstratedStep] = []
    held: str | None = None
    for i, raw in enumerate(_sequence(value, name, "steps")):
        key = f"steps[{i}]"
        entry = _mapping(raw, name, key, {"pick", "place"})
        if len(entry) != 1:
            raise SceneFileError(f"{name}: {key}: one of 'pick' and 'place', got {sorted(entry)}")
        if "pick" in entry:
            if held is not None:
                raise SceneFileError(f"{name}: {key}: picks while '{held}' is still held; place it first")
            held = _known(entry["pick"], name, f"{key}.pick", known)
            steps.append(DemonstratedStep(StepKind.PICK, held))
            continue
        if held is None:
            raise SceneFileError(f"{name}: {key}: places but nothing is held; pick first")
        steps.append(_place(entry["place"], name, f"{key}.place", known, held))
        held = None
    if held is not None or not steps:
        raise SceneFileError(f"{name}: steps: must be pick and place in turn and end with a place")
    return tuple(steps)


def _place(value: object, name: str, key: str, known: set[str], held: str) -> DemonstratedStep:
    place = _mapping(value, name, key, {"onto", "at", "offset", "turn"})
    if ("onto" in place) == ("at" in place):
        raise SceneFileError(f"{name}: {key}: exactly one of 'onto' (an object) and 'at' ([x, y])")
    if "at" in place and "offset" in place:
        raise SceneFileError(f"{name}: {key}.offset: goes with 'onto' only; put it into 'at'")
    turn = None if place.get("turn") is None else math.radians(_number(place["turn"], name, f"{key}.turn"))
    if "at" in place:
        x, y = _numbers(place["at"], name, f"{key}.at", 2)
        return DemonstratedStep(StepKind.PLACE, held, None, (x, y), turn)
    onto = _known(place["onto"], name, f"{key}.onto", known)
    if onto == held:
        raise SceneFileError(f"{name}: {key}.onto: '{held}' cannot be placed onto itself")
    x, y = _numbers(place.get("offset", [0.0, 0.0]), name, f"{key}.offset", 2)
    return DemonstratedStep(StepKind.PLACE, held, onto, (x, y), turn)


def _solution(
    value: object, name: str, source: tuple[ObjectSpec, ...], target: tuple[ObjectSpec, ...]
) -> dict[str, tuple[str, ...]]:
    sources = {o.name for o in source}
    targets = {o.name for o in target}
    solution: dict[str, tuple[str, ...]] = {}
    for key, raw in _mapping(value, name, "solution", sources).items():
        names = _sequence(raw, name, f"solution.{key}")
        if not names:
            raise SceneFileError(f"{name}: solution.{key}: needs at least one target name")
        solution[key] = tuple(_known(n, name, f"solution.{key}", targets) for n in names)
    return solution


def _mapping(value: object, name: str, key: str, allowed: set[str]) -> dict[str, object]:
    if not isinstance(value, dict):
        raise SceneFileError(f"{name}: {key}: expected a mapping, got {value!r}")
    if extra := sorted(str(k) for k in value if k not in allowed):
        raise SceneFileError(f"{name}: {key}: unknown {extra}; known are {sorted(allowed)}")
    return value


def _sequence(value: object, name: str, key: str) -> Sequence[object]:
    if not isinstance(value, list):
        raise SceneFileError(f"{name}: {key}: expected a list, got {value!r}")
    return value


def _text(value: object, name: str, key: str) -> str:
    if not isinstance(value, str) or not value:
        raise SceneFileError(f"{name}: {key}: expected a name, got {value!r}")
    return value


def _known(value: object, name: str, key: str, known: set[str]) -> str:
    text = _text(value, name, key)
    if text not in known:
        raise SceneFileError(f"{name}: {key}: no object '{text}' in that set; it has {sorted(known)}")
    return text


def _number(value: object, name: str, key: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise SceneFileError(f"{name}: {key}: expected a number, got {value!r}")
    return float(value)


def _numbers(value: object, name: str, key: str, count: int) -> tuple[float, ...]:
    entries = _sequence(value, name, key)
    if len(entries) != count:
        raise SceneFileError(f"{name}: {key}: expected {count} numbers, got {value!r}")
    return tuple(_number(entry, name, key) for entry in entries)
