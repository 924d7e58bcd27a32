"""Reader of the public user-study folder (layout: TescaF/interactive_mapping, data/hri17).

A session folder ``uN_tM`` holds ``source_objects.txt``, ``target_objects.txt``, ``targeters.txt`` (the steps) and
``hints.txt`` (the assists); beside the sessions lie ``knowledge/`` and ``solutions/``. Files: cm; here: m.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from mbd_model.assists import Assist
from mbd_model.errors import MbdError
from mbd_model.geometry.spatial import spatial_relations
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

NO_HUE = -1000.0
SESSION = re.compile(r"u(\d+)_t(\d+)")
Sets = Mapping[str, frozenset[str]]


class StudyFolderError(MbdError):
    """A file of the study folder is missing or not as described."""


@dataclass(frozen=True)
class StudySession:
    """One recorded session.

    Attributes:
        name: "u2_t0": participant 2, task 0.
        task: the demonstrated steps over the source scene.
        target: the target scene.
        assists: as the study used them, in order.
        solution: acceptable target ids of each source id.
        hints: the target ids as the study's file has them, repeats included.
    """

    name: str
    task: Task
    target: Scene
    assists: tuple[Assist, ...]
    solution: Mapping[str, frozenset[str]]
    hints: tuple[str, ...] = ()

    def solved_by(self, mapping: Mapping[str, str]) -> bool:
        """True when every object used in the demonstration goes to an acceptable target."""
        return all(mapping.get(s) in self.solution.get(s, frozenset()) for s in self.task.used_objects)


@dataclass(frozen=True)
class StudyReading:
    """What a study folder holds.

    Attributes:
        sessions: every session that could be read, by task, then participant.
        problems: what was wrong with each of the others, one sentence each.
    """

    sessions: tuple[StudySession, ...]
    problems: tuple[str, ...]


def read_study(folder: Path) -> tuple[StudySession, ...]:
    """Every session of the folder, by task, then participant. Raises StudyFolderError naming each file and line."""
    reading = read_what_can_be_read(folder)
    if reading.problems:
        raise StudyFolderError("; ".join(reading.problems))
    return reading.sessions


def read_what_can_be_read(folder: Path) -> StudyReading:
    """The sessions that are complete, and what is wrong with the others: one broken file loses no other session.

    Raises StudyFolderError when there is no session at all, or no knowledge that all of them need.
    """
    found = [(int(m[2]), int(m[1]), p) for p in folder.glob("u*_t*") if (m := SESSION.fullmatch(p.name))]
    if not found:
        raise StudyFolderError(
            f"no session folder such as u2_t0 in {folder}; give the folder data/hri17 of the public study repository"
        )
    affordances, properties = _knowledge(folder / "knowledge")
    sessions, problems = [], []
    for task, _, path in sorted(found):
        try:
            sessions.append(_session(path, affordances, properties, _solution(folder / "solutions" / f"t{task}.txt")))
        except MbdError as error:
            problems.append(f"{path.name} is left out: {error}")
    return StudyReading(tuple(sessions), tuple(problems))


def used_assists(hints: Sequence[str]) -> tuple[str, ...]:
    """The hints without an immediate repeat, and without a pair in a row that repeats an earlier pair in a row."""
    kept: list[str] = []
    for hint in hints:
        if kept and kept[-1] == hint:
            continue
        kept.append(hint)
        earlier = [tuple(kept[k : k + 2]) for k in range(len(kept) - 3)]
        if tuple(kept[-2:]) in earlier:
            del kept[-2:]
    return tuple(kept)


def _lines(path: Path) -> list[str]:
    try:
        return [line.strip() for line in path.read_text(encoding="utf-8-sig").splitlines() if line.strip()]
    except OSError as error:
        raise StudyFolderError(f"cannot read {path}: {error.strerror}; the study folder is incomplete") from error
    except UnicodeDecodeError as error:
        raise StudyFolderError(f"cannot read {path}: it is no text (UTF-8); copy it from the study again") from error


def _knowledge(folder: Path) -> tuple[Sets, Sets]:
    """Affordances and properties by object id, all files in one table."""
    tables: tuple[dict[str, frozenset[str]], dict[str, frozenset[str]]] = ({}, {})
    for file in sorted(folder.glob("*.txt")):
        lines = _lines(file)
        if len(lines) != len(tables):
            raise StudyFolderError(f"{file} has {len(lines)} lines; expected one of affordances and one of properties")
        for table, line in zip(tables, lines, strict=True):
            for entry in line.split(";")[1:]:
                name, _, values = entry.partition(":")
                table[name] = frozenset(values.split(",")) if values else frozenset()
    if not tables[0]:
        raise StudyFolderError(f"no affordances in {folder}; expected lines such as affordances;red_cup:pourable")
    return tables


def _solution(path: Path) -> Sets:
    pairs = [line.partition(":") for line in _lines(path)]
    if not pairs or not all(source and targets for source, _, targets in pairs):
        raise StudyFolderError(f"{path}: expected lines such as milk:juice or red:red_1,red_2")
    return {source.strip(): frozenset(t.strip() for t in targets.split(",")) for source, _, targets in pairs}


def _scene(path: Path, role: Role, affordances: Sets, properties: Sets) -> Scene:
    objects = []
    for number, line in enumerate(_lines(path), start=1):
        if ";" in line.partition("{")[0]:
            raise StudyFolderError(f"{path}:{number}: separated by semicolons; expected id,x,y,z,w,d,h,hue,...")
        name, *rest = line.split(",")
        try:
            x, y, z, width, depth, height, hue = (float(value) for value in rest[:7])
        except ValueError:
            raise StudyFolderError(f"{path}:{number}: expected id,x,y,z,w,d,h,hue,...: got '{line}'") from None
        with _named(f"{path}:{number}"):
            objects.append(
                SceneObject(
                    name,
                    (x, y, z),
                    (width / 100.0, depth / 100.0, height / 100.0),
                    hue=None if hue == NO_HUE else hue % 360.0,
                    affordances=affordances.get(name, frozenset()),
                    properties=properties.get(name, frozenset()),
                )
            )
    if not objects:
        raise StudyFolderError(f"{path} is empty: expected a line id,x,y,z,w,d,h,hue,... for each object")
    relations = spatial_relations(objects)
    with _named(str(path)):
        return Scene(role, tuple(replace(o, relations=r) for o, r in zip(objects, relations, strict=True)))


@contextmanager
def _named(where: str) -> Iterator[None]:
    """Name the file when a value cannot be."""
    try:
        yield
    except MbdError as error:
        raise StudyFolderError(f"{where}: {error}") from error


def _session(path: Path, affordances: Sets, properties: Sets, solution: Sets) -> StudySession:
    source = _scene(path / "source_objects.txt", Role.SOURCE, affordances, properties)
    target = _scene(path / "target_objects.txt", Role.TARGET, affordances, properties)
    steps = []
    # The last line of the file is where the gripper went after the task: no step.
    for number, line in enumerate(_lines(path / "targeters.txt")[:-1]):
        named = re.match(r"\(([^)]+)\)", line)
        if named is None:
            raise StudyFolderError(f"{path / 'targeters.txt'}:{number + 1}: no (object) at the start of '{line}'")
        kind = StepKind.PLACE if number % 2 else StepKind.PICK
        # The file's offsets from the gripper are partly garbage, so no distance is known.
        steps.append(TaskStep(index=number, kind=kind, primary_object=named[1], distance=0.0))
    with _named(str(path / "targeters.txt")):
        task = Task(source, tuple(steps))
    if not steps:
        raise StudyFolderError(f"{path / 'targeters.txt'} has no step: expected lines (object)... and a last one")
    hints = tuple(_lines(path / "hints.txt"))
    if hints and not any(hint in target.ids for hint in hints):
        raise StudyFolderError(
            f"{path / 'hints.txt'}: none of its lines names a target object, the first is '{hints[0]}'; "
            f"expected one of {', '.join(target.ids)} a line and nothing else"
        )
    assists = tuple(
        Assist(step.primary_object, hint, step.index)
        for step, hint in zip(task.steps, used_assists(hints), strict=False)
    )
    return StudySession(path.name, task, target, assists, solution, hints)
