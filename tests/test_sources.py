"""The sources as a house: names that mean one thing, rooms that are not too full, doors that are kept shut."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[1] / "ros2_ws" / "src"
PACKAGES = sorted(p / p.name for p in SRC.iterdir() if (p / p.name / "__init__.py").exists())
MODULES = sorted(file for package in PACKAGES for file in package.rglob("*.py"))
# Private names of other classes that there is no public way to, by file and name, each with its reason.
UNAVOIDABLE: dict[tuple[str, str], str] = {
    ("mbd_model/mbd_model/command_line/parser.py", "_actions"): "argparse states its sub-commands in no public place",
    ("mbd_model/mbd_model/command_line/parser.py", "_option_string_actions"): "argparse states no options in public",
}
SHARE = 0.16  # of all lines, that one package may have
ROOM = 15  # modules side by side


def name_of(file: Path) -> str:
    return str(file.relative_to(SRC))


@cache
def tree_of(file: Path) -> ast.Module:
    return ast.parse(file.read_text())


def classes(tree: ast.Module) -> Iterator[str]:
    yield from (node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef))


def test_no_class_name_means_two_things():
    homes = defaultdict(list)
    for file in MODULES:
        for name in classes(tree_of(file)):
            homes[name].append(name_of(file))
    assert len(homes) > 200
    assert {name: files for name, files in homes.items() if len(files) > 1} == {}


def aliases(tree: ast.Module) -> Iterator[str]:
    """Names given to types at the top of a module; a TypeVar stands for any type, and means nothing by itself."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and "TypeVar" not in ast.dump(node):
            name = node.targets[0].id
            if name[0].isupper() and not name.isupper():
                yield name


def test_no_name_of_a_type_is_a_class_elsewhere():
    trees = {name_of(file): tree_of(file) for file in MODULES}
    named = {name: file for file, tree in trees.items() for name in classes(tree)}
    given = {(name, file) for file, tree in trees.items() for name in aliases(tree)}
    assert len(given) > 30
    assert {f"{name} of {file} is a class of {named[name]}" for name, file in given if name in named} == set()


def test_a_class_named_as_a_message_is_the_value_that_the_message_carries():
    """So it lies in the shared vocabulary, where the conversions are, and nowhere else."""
    messages = {file.stem for file in (SRC / "mbd_msgs").glob("*/*.*") if file.suffix in {".msg", ".srv", ".action"}}
    named = {
        (name, name_of(file))
        for file in MODULES
        for name in classes(tree_of(file))
        if name in messages and SRC / "mbd_model" not in file.parents
    }
    assert named == set()


def test_no_package_has_more_than_its_share_of_the_lines():
    lines = {p.name: sum(len(f.read_text().splitlines()) for f in p.rglob("*.py")) for p in PACKAGES}
    total = sum(lines.values())
    assert {name: f"{count / total:.1%}" for name, count in lines.items() if count > SHARE * total} == {}


def test_no_folder_has_more_modules_side_by_side_than_one_can_look_over():
    rooms = defaultdict(int)
    for file in MODULES:
        rooms[name_of(file.parent)] += file.name != "__init__.py"
    assert {room: count for room, count in rooms.items() if count > ROOM} == {}


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name != "_"


def names_defined_in(node: ast.ClassDef) -> set[str]:
    """Of methods, class attributes, and attributes that methods assign."""
    names = set()
    for inner in ast.walk(node):
        if isinstance(inner, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            names.add(inner.name)
        elif isinstance(inner, ast.Attribute) and isinstance(inner.ctx, ast.Store):
            if isinstance(inner.value, ast.Name) and inner.value.id in {"self", "cls"}:
                names.add(inner.attr)
        elif isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Store):
            names.add(inner.id)
    return names


class PrivateAccess(ast.NodeVisitor):
    """Collects private names taken of another class or module, by attribute, import or string."""

    def __init__(self) -> None:
        self.own: list[set[str]] = []
        self.found: list[str] = []

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.own.append(names_defined_in(node))
        self.generic_visit(node)
        self.own.pop()

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if is_private(node.attr) and not (self.own and node.attr in self.own[-1]):
            self.found.append(node.attr)
        self.generic_visit(node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        self.found += [alias.name for alias in node.names if is_private(alias.name)]

    def visit_Call(self, node: ast.Call) -> None:
        if isinstance(node.func, ast.Name) and node.func.id in {"getattr", "setattr", "hasattr", "delattr"}:
            names = [a.value for a in node.args[1:2] if isinstance(a, ast.Constant) and isinstance(a.value, str)]
            self.found += [name for name in names if is_private(name)]
        self.generic_visit(node)


def private_names_taken(tree: ast.Module) -> list[str]:
    visitor = PrivateAccess()
    visitor.visit(tree)
    return visitor.found


def test_no_class_takes_what_another_keeps_to_itself():
    taken = {(name_of(file), name) for file in MODULES for name in private_names_taken(tree_of(file))}
    assert taken - UNAVOIDABLE.keys() == set()
    assert UNAVOIDABLE.keys() - taken == set(), "no longer taken: strike it from the list"


@pytest.mark.parametrize(
    "source",
    [
        "class A:\n    def f(self, other):\n        return other._x",
        "class A:\n    def f(self):\n        return self._x",  # of a base class elsewhere
        "class A:\n    def f(self, other):\n        other._x = 1",
        "class A:\n    _x = 1\nclass B:\n    def f(self, a):\n        return a._x",
        "class A:\n    _x = 1\ndef f(a):\n    return a._x",
        "def f(a):\n    return getattr(a, '_x')",
        "from somewhere import _x",
        "import somewhere\nsomewhere._x()",
    ],
)
def test_taking_a_private_name_is_noticed(source: str):
    assert private_names_taken(ast.parse(source)) == ["_x"]


@pytest.mark.parametrize(
    "source",
    [
        "class A:\n    def __init__(self):\n        self._x = 1\n    def f(self):\n        return self._x",
        "class A:\n    _x: int = 0\n    def __eq__(self, other):\n        return self._x == other._x",
        "class A:\n    def _x(self): ...\n    def f(self):\n        return self._x()",
        "def f(a):\n    return a.__class__",
        "_x = 1\ndef f():\n    return _x",
    ],
)
def test_ones_own_private_name_is_ones_own(source: str):
    assert private_names_taken(ast.parse(source)) == []
