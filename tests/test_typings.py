"""The stubs that mypy reads in place of ROS say what ROS has, and mypy finds mistakes by them."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]
TYPINGS = ROOT / "typings"
MODULES = sorted((TYPINGS / "rclpy").rglob("*.pyi"))


def module_of(file: Path) -> ModuleType:
    parts = file.relative_to(TYPINGS).with_suffix("").parts
    return importlib.import_module(".".join(parts[:-1] if parts[-1] == "__init__" else parts))


def real_parameters(thing: object) -> dict[str, inspect.Parameter] | None:
    """None where Python does not know: functions of a C++ module."""
    try:
        return dict(inspect.signature(thing).parameters)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None


def mistakes(owner: object, body: list[ast.stmt], where: str) -> Iterator[str]:
    """What a stub says and the real thing has not, a sentence each."""
    for node in body:
        if isinstance(node, ast.ClassDef):
            if any("Protocol" in ast.unparse(base) for base in node.bases):
                continue  # a description of an object whose class has no name of its own
            real = getattr(owner, node.name, None)
            if not isinstance(real, type):
                yield f"{where} has no class {node.name}"
            else:
                yield from mistakes(real, node.body, f"{where}.{node.name}")
        elif isinstance(node, ast.FunctionDef):
            yield from mistakes_of_function(owner, node, where)
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            name = ast.unparse(node.targets[0])
            value = getattr(owner, name, None)
            if getattr(value, "value", value) != node.value.value:
                yield f"{where}.{name} is {value}, not {node.value.value}"


def mistakes_of_function(owner: object, node: ast.FunctionDef, where: str) -> Iterator[str]:
    real = inspect.getattr_static(owner, node.name, None)
    if real is None:
        yield f"{where} has no {node.name}"
        return
    if any(ast.unparse(d) == "property" for d in node.decorator_list):
        if not isinstance(real, property):
            yield f"{where}.{node.name} is no property"
        return
    parameters = real_parameters(getattr(real, "__func__", real))
    if parameters is None or any(p.kind is p.VAR_KEYWORD for p in parameters.values()):
        return
    said = {a.arg for a in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)} - {"self", "cls"}
    needed = {n for n, p in parameters.items() if p.default is p.empty and p.kind is not p.VAR_POSITIONAL}
    for name in sorted(said - parameters.keys()):
        yield f"{where}.{node.name} takes no {name}"
    for name in sorted(needed - said - {"self", "cls"}):
        yield f"{where}.{node.name} needs {name}"


@pytest.mark.parametrize("file", MODULES, ids=lambda f: str(f.relative_to(TYPINGS).with_suffix("")))
def test_rclpy_has_what_its_stub_states(file: Path):
    found = list(mistakes(module_of(file), ast.parse(file.read_text()).body, str(file.relative_to(TYPINGS))))
    assert found == []


@pytest.mark.parametrize(
    ("stub", "mistake"),
    [
        ("class Nod: ...", "no class Nod"),
        ("class Node:\n    def get_nam(self) -> str: ...", "no get_nam"),
        ("class Node:\n    def get_parameter(self, nam: str) -> object: ...", "takes no nam"),
        ("class Node:\n    def get_parameter(self) -> object: ...", "needs name"),
        ("class Node:\n    @property\n    def get_name(self) -> str: ...", "no property"),
    ],
)
def test_a_stub_that_states_something_else_is_noticed(stub: str, mistake: str):
    found = list(mistakes(importlib.import_module("rclpy.node"), ast.parse(stub).body, "rclpy.node"))
    assert any(mistake in sentence for sentence in found), found


@pytest.fixture(scope="module")
def stubs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("stubs")
    subprocess.run([sys.executable, str(ROOT / "tools" / "message_stubs"), str(folder)], check=True)
    return folder


def test_every_message_stub_has_the_fields_of_the_generated_class(stubs: Path):
    compared = 0
    for file in sorted(stubs.glob("*/*/__init__.pyi")):
        module = importlib.import_module(".".join(file.parent.relative_to(stubs).parts))
        for node in ast.parse(file.read_text()).body:
            if not isinstance(node, ast.ClassDef) or any("ros_kinds" in ast.unparse(b) for b in node.bases):
                continue
            name, _, part = node.name.partition("_")
            real = getattr(getattr(module, name), part) if part else getattr(module, name)
            said = [f.target.id for f in node.body if isinstance(f, ast.AnnAssign) and isinstance(f.target, ast.Name)]
            # Fields that are read as another type than they may be assigned are properties.
            said += [
                f.name
                for f in node.body
                if isinstance(f, ast.FunctionDef) and "property" in map(ast.unparse, f.decorator_list)
            ]
            assert {n for n in said if not n.isupper()} == set(real.get_fields_and_field_types()), node.name
            assert all(hasattr(real, n) for n in said if n.isupper()), node.name
            compared += 1
    assert compared > 100


SNIPPET = """
from mbd_msgs import msg as m
from mbd_msgs.action import MoveTool
from mbd_msgs.srv import Observe
from rclpy.action import ActionClient
from rclpy.node import Node
from std_srvs.srv import Trigger
def on_scene(msg: m.Scene) -> None: ...
def on_observe(request: Observe.Request, response: Observe.Response) -> Observe.Response: return response
def use(node: Node, arm: ActionClient[MoveTool.Goal, MoveTool.Result, MoveTool.Feedback]) -> None:
    scene = m.Scene(objects=[m.ObjectFeatures()])
    scene.header.stamp = node.get_clock().now().to_msg()
    node.create_subscription(m.Scene, "scene", on_scene, 1)
    node.create_service(Observe, "observe", on_observe)
    node.create_publisher(m.Scene, "scene", 1).publish(scene)
    arm.send_goal_async(MoveTool.Goal(speed=0.1))
    scene.objcts  # error: has no attribute "objcts"
    m.Scene(objct=[])  # error: Unexpected keyword argument "objct"
    scene.objects = 3  # error: Incompatible types in assignment
    node.create_subscription(m.Task, "task", on_scene, 1)  # error: incompatible type
    node.create_service(Trigger, "observe", on_observe)  # error: incompatible type
    node.create_publisher(m.Task, "task", 1).publish(scene)  # error: incompatible type
    node.create_client(Observe, "observe").call_async(Trigger.Request())  # error: incompatible type
    arm.send_goal_async(scene)  # error: incompatible type
    node.get_name_of_it()  # error: has no attribute "get_name_of_it"
"""


@pytest.mark.node  # seconds: mypy reads numpy without its cache
def test_mypy_finds_what_does_not_fit_a_message_a_service_or_an_action(stubs: Path, tmp_path: Path):
    file = tmp_path / "snippet.py"
    file.write_text(SNIPPET)
    config = tmp_path / "mypy.ini"
    config.write_text(f"[mypy]\nstrict = true\nmypy_path = {TYPINGS}:{stubs}\n")
    words = [sys.executable, "-m", "mypy", "--config-file", str(config), "--cache-dir", str(tmp_path / "c"), str(file)]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    found = {int(k): text for k, text in re.findall(r"snippet\.py:(\d+): error: (.*)", done.stdout)}
    expected = {
        number: line.partition("# error: ")[2]
        for number, line in enumerate(SNIPPET.splitlines(), start=1)
        if "# error: " in line
    }
    assert found.keys() == expected.keys(), done.stdout
    assert all(text in found[number] for number, text in expected.items()), done.stdout
