"""A person's own files of parameters reach the nodes that they are for, or are refused before any node starts."""

from __future__ import annotations

from pathlib import Path

import pytest
from mbd_bringup.launch_arguments import ARGUMENTS, options_of
from mbd_bringup.nodes import NodeSpec, SessionOptions, session_nodes
from mbd_bringup.processes import SessionProcesses
from mbd_experiments.user_study.lab_prior_command import write_parameters
from mbd_mapping.teachers.lab_prior import LabPrior
from mbd_model.errors import MbdError

CAMERA = "/**:\n  ros__parameters:\n    camera_position: [0.5, 0.1, 1.1]\n"
WORKSPACE = "perception:\n  ros__parameters:\n    workspace_x: [0.3, 0.9]\n"


def asked(folder: Path, **given: str) -> SessionOptions:
    words = {name: argument.default for name, argument in ARGUMENTS.items()}
    return options_of(words | {"folder": str(folder)} | given)


def by_name(options: SessionOptions) -> dict[str, NodeSpec]:
    return {spec.executable: spec for spec in session_nodes(options)}


@pytest.mark.parametrize("simulated", ["true", "false"])
def test_a_camera_s_file_takes_the_place_of_ours_for_perception_and_console(tmp_path: Path, simulated: str):
    (tmp_path / "camera.yaml").write_text(CAMERA)
    (tmp_path / "workspace.yaml").write_text(WORKSPACE)
    made = by_name(
        asked(
            tmp_path,
            simulated=simulated,
            console="true",
            camera_file=str(tmp_path / "camera.yaml"),
            workspace_file=str(tmp_path / "workspace.yaml"),
        )
    )
    camera, workspace = ("", str(tmp_path / "camera.yaml")), ("", str(tmp_path / "workspace.yaml"))
    assert made["perception"].config == (camera, workspace)
    assert made["console"].config == (camera,)
    prefixes = {"mbd_perception": tmp_path}
    executable = tmp_path / "lib" / "mbd_perception" / "perception"
    executable.parent.mkdir(parents=True)
    executable.touch()
    command = SessionProcesses(prefixes, tmp_path, {}).command(made["perception"])
    assert [w for w, before in zip(command[1:], command, strict=False) if before == "--params-file"] == [
        camera[1], workspace[1],
    ]  # fmt: skip


def test_what_earlier_sessions_taught_is_given_to_the_mapping(tmp_path: Path):
    file = tmp_path / "prior.yaml"
    write_parameters(LabPrior(), file)
    made = by_name(asked(tmp_path, lab_prior=str(file)))
    assert made["mapping"].config == (("", str(file)),)
    assert by_name(asked(tmp_path))["mapping"].config == ()


@pytest.mark.parametrize(
    ("argument", "text", "why"),
    [
        ("camera_file", None, "camera_file:=.* is no file"),
        ("camera_file", "a: [", "is no ROS parameter file"),
        ("camera_file", "camera_position: [0, 0, 1]", "has no parameter for perception"),
        ("camera_file", CAMERA.replace("position", "positoin"), "did you mean 'camera_position'"),
        ("camera_file", CAMERA.replace("[0.5, 0.1, 1.1]", "high"), "camera_position"),
        ("workspace_file", WORKSPACE.replace("perception", "mapping"), "has no parameter for perception"),
        ("lab_prior", WORKSPACE, "has no parameter for mapping"),
    ],
)
def test_a_file_that_no_node_would_take_is_refused(tmp_path: Path, argument: str, text: str | None, why: str):
    file = tmp_path / "mine.yaml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(MbdError, match=why):
        asked(tmp_path, **{argument: str(file)})
