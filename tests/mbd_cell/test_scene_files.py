"""Scene files are either usable in one piece, or refused with the file's name and the key."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from mbd_cell.layout.scene_file import SceneFileError, load_scenes, parse_scenes
from mbd_cell.layout.scenes import Shape
from mbd_cell.physics.camera_pose import CELL_CAMERA, surveyed_pose
from mbd_model.errors import MbdError
from mbd_model.task import StepKind
from shipped_scenes import TASKS, scenes_of

GOOD: dict[str, Any] = {
    "task": "t",
    "source": [
        {"name": "a", "shape": "cup", "size": [0.05, 0.05, 0.06], "hue": 10, "mass": 0.1},
        {"name": "b", "shape": "bowl", "size": [0.12, 0.12, 0.05], "hue": 20, "mass": 0.1},
    ],
    "target": [{"name": "c", "shape": "box", "size": [0.05, 0.04, 0.06], "mass": 0.1}],
    "steps": [{"pick": "a"}, {"place": {"onto": "b"}}],
    "solution": {"a": ["c"], "b": ["c"]},
}


@pytest.mark.parametrize("task", TASKS)
def test_every_shipped_task_is_valid_and_alternates_pick_and_place(task: str) -> None:
    kinds = [step.kind for step in scenes_of(task).steps]
    assert kinds == [StepKind.PICK, StepKind.PLACE] * (len(kinds) // 2)


@pytest.mark.parametrize("task", TASKS)
def test_every_object_of_a_shipped_task_is_used_and_has_a_right_target(task: str) -> None:
    scenes = scenes_of(task)
    used = {s.picked for s in scenes.steps} | {s.onto for s in scenes.steps if s.onto}
    assert used == {o.name for o in scenes.source} == set(scenes.solution)


def test_the_tasks_have_the_papers_numbers_of_objects() -> None:
    assert [len(scenes_of(t).source) for t in TASKS] == [5, 6, 4, 7, 6]
    assert [len(scenes_of(t).target) for t in TASKS] == [5, 6, 4, 7, 6]
    assert {o.shape for o in scenes_of("sorting").source} == {Shape.CUP}
    assert {o.shape for o in scenes_of("sorting").target} == {Shape.BOWL}


def test_the_document_the_broken_ones_are_made_from_is_good() -> None:
    assert parse_scenes(GOOD, "good.yaml").steps[1].onto == "b"


def _set(*path: Any, value: Any) -> Callable[[Any], None]:
    def change(document: Any) -> None:
        for key in path[:-1]:
            document = document[key]
        document[path[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (_set("sauce", value=1), "sauce"),
        (_set("task", value=3), "task"),
        (_set("source", value=[]), "source"),
        (_set("source", 0, "shape", value="mug"), r"source\[0\] \(a\)\.shape"),
        (_set("source", 0, "size", value=[0.05, 0.06, 0.06]), r"source\[0\] \(a\)\.size"),
        (_set("source", 0, "size", value=[5, 5, 6]), r"source\[0\] \(a\)\.size"),
        (_set("source", 1, "hue", value=400), r"source\[1\] \(b\)\.hue"),
        (_set("source", 1, "mass", value=float("nan")), r"source\[1\] \(b\)\.mass"),
        (_set("source", 1, "upside_down", value=True), r"source\[1\] \(b\)\.upside_down"),
        (_set("source", 1, "name", value="a"), "source"),
        (_set("target", 0, "region", value=[0.5, 0.4, 0, 1]), r"target\[0\] \(c\)\.region"),
        (_set("arrangement", value="circle"), "arrangement"),
        (_set("steps", 0, value={"pick": "z"}), r"steps\[0\]\.pick"),
        (_set("steps", 0, value={"place": {"at": [0.4, 0]}}), r"steps\[0\]"),
        (_set("steps", 1, value={"pick": "b"}), r"steps\[1\]"),
        (_set("steps", 1, value={"place": {"onto": "a"}}), r"steps\[1\]\.place\.onto"),
        (_set("steps", 1, value={"place": {"onto": "b", "at": [0.4, 0]}}), r"steps\[1\]\.place"),
        (_set("steps", value=[{"pick": "a"}]), "steps"),
        (_set("solution", value={"a": ["c"]}), "solution"),
        (_set("solution", "a", value=["b"]), r"solution\.a"),
    ],
)
def test_a_bad_value_is_refused_with_file_and_key(change: Callable[[Any], None], key: str) -> None:
    document = copy.deepcopy(GOOD)
    change(document)
    with pytest.raises(SceneFileError, match=rf"bad\.yaml: {key}|bad\.yaml: \(top\).*{key}"):
        parse_scenes(document, "bad.yaml")


def test_an_unknown_task_is_refused_with_the_tasks_there_are(config: Path) -> None:
    with pytest.raises(SceneFileError, match="sorting") as caught:
        load_scenes(config / "juggling.yaml")
    assert "camera" not in str(caught.value).partition("tasks there")[2]


def test_a_file_that_is_no_yaml_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.yaml").write_text("task: [")
    with pytest.raises(SceneFileError, match=r"x\.yaml is not valid YAML"):
        load_scenes(tmp_path / "x.yaml")


def test_the_parameter_file_states_where_the_cells_camera_is(config: Path) -> None:
    parameters = yaml.safe_load((config / "camera.yaml").read_text())["/**"]["ros__parameters"]
    pose = surveyed_pose(parameters["camera_position"], parameters["camera_orientation"])
    assert pose.position.tolist() == CELL_CAMERA.position.tolist()
    assert pose.rotation == pytest.approx(CELL_CAMERA.rotation)


@pytest.mark.parametrize(("position", "orientation"), [([0, 0], [0, 0, 0, 1]), ([0, 0, 1], [0, 0, 0, 2])])
def test_a_camera_pose_that_is_none_is_refused(position: list[float], orientation: list[float]) -> None:
    with pytest.raises(MbdError, match="camera"):
        surveyed_pose(position, orientation)
