"""Every package is one that colcon, rosdep and ros2 run accept, and the repository holds nothing it must not."""

from __future__ import annotations

import ast
import configparser
import importlib
import os
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from catkin_pkg.package import parse_package

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = sorted(p.parent for p in (ROOT / "ros2_ws" / "src").glob("*/package.xml"))
PYTHON_PACKAGES = [p for p in PACKAGES if (p / "setup.py").exists()]
# Keys of rosdistro's python.yaml and of Jazzy's packages that we rely on; rosdep stops on a key it does not know.
ROSDEP_KEYS = {
    "action_msgs",
    "ament_cmake",
    "ament_index_python",
    "builtin_interfaces",
    "control_msgs",
    "diagnostic_msgs",
    "geometry_msgs",
    "launch",
    "launch_ros",
    "python3-hypothesis",
    "python3-matplotlib",
    "python3-numpy",
    "python3-opencv",
    "python3-pil",
    "python3-pytest",
    "python3-pytest-timeout",
    "python3-rich",
    "python3-scipy",
    "python3-yaml",
    "rcl_interfaces",
    "rclpy",
    "rosgraph_msgs",
    "rosidl_default_generators",
    "rosidl_default_runtime",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "trajectory_msgs",
    "unique_identifier_msgs",
    "visualization_msgs",
}


def tracked_files() -> list[Path]:
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("not a git checkout: there is no list of tracked files")
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


@pytest.mark.parametrize("package", PACKAGES, ids=lambda p: p.name)
def test_its_manifest_is_valid_and_its_dependencies_have_keys(package: Path):
    manifest = parse_package(package)
    assert manifest.name == package.name
    assert manifest.licenses == ["Apache-2.0"]
    ours = {p.name for p in PACKAGES}
    wanted = {d.name for d in manifest.exec_depends + manifest.build_depends + manifest.test_depends}
    assert wanted - ours - ROSDEP_KEYS == set()


@pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda p: p.name)
def test_what_it_imports_of_ours_and_of_ros_is_declared(package: Path):
    declared = {d.name for d in parse_package(package).exec_depends}
    used = set()
    for file in (package / package.name).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                used |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                used.add((node.module or "").partition(".")[0])
    known = {p.name for p in PACKAGES} | {k for k in ROSDEP_KEYS if "-" not in k}
    assert (used & known) - declared - {package.name} == set()


@pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda p: p.name)
def test_every_executable_it_names_can_be_called(package: Path):
    for line in re.findall(r'"(\w+ = [\w.]+:\w+)"', (package / "setup.py").read_text()):
        module, _, function = line.partition(" = ")[2].partition(":")
        assert callable(getattr(importlib.import_module(module), function)), line


@pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda p: p.name)
def test_ament_finds_it_after_installation(package: Path):
    assert (package / "resource" / package.name).exists()


@pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda p: p.name)
def test_its_setup_files_differ_from_the_others_in_its_name_only(package: Path):
    first = PYTHON_PACKAGES[0]
    expected = (first / "setup.cfg").read_text().replace(first.name, package.name)
    assert (package / "setup.cfg").read_text() == expected
    assert f"script_dir=$base/lib/{package.name}" in expected
    before_the_call = (first / "setup.py").read_text().partition("install(")[0].replace(first.name, package.name)
    assert (package / "setup.py").read_text().startswith(before_the_call)


@pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda p: p.name)
def test_colcon_test_finds_its_tests(package: Path):
    cfg = configparser.ConfigParser()
    cfg.read(package / "setup.cfg")
    assert list((package / cfg["tool:pytest"]["testpaths"]).glob("test_*.py"))


@pytest.mark.system
@pytest.mark.parametrize("plugins", [{}, {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}], ids=["plain", "env.sh"])
def test_colcon_test_runs_them_where_only_what_the_package_depends_on_is_on_the_path(
    tmp_path: Path, plugins: dict[str, str]
):
    """As on a normal install after `colcon build`, with nothing of the overlay sourced; and as env.sh has it."""
    install = str(ROOT / "ros2_ws" / "install")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("COLCON", "PYTEST"))} | plugins
    for path in ("AMENT_PREFIX_PATH", "PYTHONPATH", "LD_LIBRARY_PATH", "CMAKE_PREFIX_PATH"):
        kept = [entry for entry in environment.get(path, "").split(os.pathsep) if not entry.startswith(install)]
        environment[path] = os.pathsep.join(kept)
    (tmp_path / "build" / "mbd_model").mkdir(parents=True)
    command = [
        *(sys.executable, "-m", "colcon", "--log-base", tmp_path / "log", "test", "--packages-select", "mbd_model"),
        *("--build-base", tmp_path / "build", "--return-code-on-test-failure", "--pytest-args", "-k", "test_spatial"),
    ]
    done = subprocess.run(
        command, cwd=ROOT / "ros2_ws", env=environment, capture_output=True, text=True, check=False, timeout=200
    )
    assert done.returncode == 0, done.stdout + done.stderr
    suite = ElementTree.parse(tmp_path / "build" / "mbd_model" / "pytest.xml").getroot().find("testsuite")
    assert suite is not None
    assert int(suite.get("tests", "0")) >= 6
    assert (suite.get("errors"), suite.get("failures")) == ("0", "0")


def test_every_message_field_states_what_it_is_or_is_plain():
    """A number with a unit must name it: every float field of a message carries a comment."""
    bare = []
    for file in (ROOT / "ros2_ws" / "src" / "mbd_msgs").glob("*/*.*"):
        for line in file.read_text().splitlines():
            if re.match(r"\s*(float(32|64)|geometry_msgs/\w+)(\[\d*\])?\s+\w+\s*$", line):
                bare.append(f"{file.name}: {line}")
    assert bare == []


def test_parameter_files_are_valid_yaml_for_ros():
    files = [f for p in PACKAGES for f in (p / "config").glob("*.yaml") if "ros__parameters" in f.read_text()]
    assert files
    for file in files:
        for node, content in yaml.safe_load(file.read_text()).items():
            # A section named after the node would not apply after a remap of its name.
            assert node.startswith("/**"), file
            assert set(content) == {"ros__parameters"}, file


def test_the_page_of_topics_names_each_that_a_session_records_with_its_type():
    page = (ROOT / "docs" / "topics.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    bags = sorted((ROOT / "bags").glob("*/metadata.yaml"))
    assert bags
    for bag in bags:
        for entry in yaml.safe_load(bag.read_text())["rosbag2_bagfile_information"]["topics_with_message_count"]:
            topic, kind = entry["topic_metadata"]["name"], entry["topic_metadata"]["type"].replace("/msg/", "/")
            if topic in {"/rosout", "/parameter_events"}:  # every ROS node's
                continue
            if kind == "sensor_msgs/CompressedImage":  # of an image, as recorded
                topic, kind = topic.rpartition("/")[0], "sensor_msgs/Image"
            row = next((r for r in rows if f"`{topic}`" in r or f"`{topic[1:]}`" in r), f"no row for {topic}")
            assert kind.removeprefix("mbd_msgs/") in row, f"{bag.parent.name}: {topic}: {row}"


FROM_PIP = "dm_control lz4 mcap mujoco nicegui open3d OpenGL rosbags zstandard"
ROBOTS_NODES = (
    "mbd_perception.ros.node mbd_demonstration.ros.node mbd_mapping.ros.node mbd_interaction.ros.node "
    "mbd_execution.ros.node mbd_bringup.ros.markers_node"
)


def test_the_nodes_that_a_robot_needs_run_with_what_rosdep_installs():
    block = (
        "import importlib, sys\n"
        f"for name in '{FROM_PIP}'.split(): sys.modules[name] = None\n"
        f"for name in '{ROBOTS_NODES}'.split(): importlib.import_module(name)\n"
    )
    done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_no_file_is_too_large_and_none_names_this_machine():
    for file in tracked_files():
        assert file.stat().st_size <= 4 * 1024 * 1024, f"{file} is over 4 MiB"
        if file != Path(__file__) and file.suffix not in {".png", ".mcap"}:
            text = file.read_text(errors="replace")
            assert not re.search(r"/wor[k]/(main|shared)|/roo[t]/|files\.pythonhosted|registry\.npmjs", text), file


def test_all_sample_bags_together_are_small():
    assert sum(f.stat().st_size for f in (ROOT / "bags").rglob("*") if f.is_file()) <= 20 * 1024 * 1024
