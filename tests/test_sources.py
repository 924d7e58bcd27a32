"""The sources as a house: names that mean one thing, rooms that are not too full, doors that are kept shut."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[1] / "ros2_ws" / "src"
PACKAGES = sorted(p / p.name for p in SRC.iterdir() if (p / p.name / "__init__.py").exists())
MODULES = sorted(file for package in PACKAGES for file in package.rglob("*.py"))
SHARE = 0.16  # of all lines, that one package may have
ROOM = 15  # modules side by side


def name_of(file: Path) -> str:
    return str(file.relative_to(SRC))


def classes(tree: ast.Module) -> Iterator[str]:
    yield from (node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef))


def test_no_class_name_means_two_things():
    homes = defaultdict(list)
    for file in MODULES:
        for name in classes(ast.parse(file.read_text())):
            homes[name].append(name_of(file))
    assert len(homes) > 200
    assert {name: files for name, files in homes.items() if len(files) > 1} == {}


def test_a_class_named_as_a_message_is_the_value_that_the_message_carries():
    """So it lies in the shared vocabulary, where the conversions are, and nowhere else."""
    messages = {file.stem for file in (SRC / "mbd_msgs").glob("*/*.*") if file.suffix in {".msg", ".srv", ".action"}}
    named = {
        (name, name_of(file))
        for file in MODULES
        for name in classes(ast.parse(file.read_text()))
        if name in messages and SRC / "mbd_model" not in file.parents
    }
    assert named == set()


def test_no_package_has_more_than_a_sixth_of_the_lines():
    lines = {p.name: sum(len(f.read_text().splitlines()) for f in p.rglob("*.py")) for p in PACKAGES}
    total = sum(lines.values())
    assert {name: f"{count / total:.1%}" for name, count in lines.items() if count > SHARE * total} == {}


def test_no_folder_has_more_modules_side_by_side_than_one_can_look_over():
    rooms = defaultdict(int)
    for file in MODULES:
        rooms[name_of(file.parent)] += file.name != "__init__.py"
    assert {room: count for room, count in rooms.items() if count > ROOM} == {}
