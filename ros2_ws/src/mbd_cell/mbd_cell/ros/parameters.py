"""The cell node's parameters as it uses them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from mbd_robot.profiles.camera import CameraProfile
from mbd_robot.profiles.find import camera_profile, robot_profile
from mbd_robot.profiles.robot import RobotProfile

from mbd_cell.physics.camera_pose import surveyed_pose
from mbd_cell.physics.grasp import Grasp
from mbd_cell.physics.robot_model import CellRobot
from mbd_cell.physics.robots import JACO, cell_robot


@dataclass(frozen=True)
class CellParameters:
    """The parameters as the node uses them; units in CELL."""

    task: str
    seed: int
    speed: float
    camera_rate: float
    camera_rate_moving: float
    grasp: Grasp
    noise: bool
    teacher: bool
    camera: CameraPose
    scenes: Path
    driver: str
    reminder: float
    robot: RobotProfile | None
    camera_driver: CameraProfile | None

    @property
    def cell_robot(self) -> CellRobot:
        """Arm and hand of the cell; raises MbdError for a robot that the cell cannot play."""
        if self.robot is None:
            return JACO
        if self.robot.stand_in is None:
            raise MbdError(
                f"the profile of '{self.robot.title}' has no stand_in: the cell does not know how to play it"
            )
        return cell_robot(self.robot.stand_in.arm, self.robot.stand_in.hand)

    def scene_file(self, task: str) -> Path:
        """Where that task's scenes are."""
        return self.scenes / f"{task}.yaml"


def cell_parameters(values: Mapping[str, Any]) -> CellParameters:
    """What values of the parameters of CELL, by name, make.

    Raises:
        MbdError: a value that cannot be used.
    """
    return CellParameters(
        task=values["task"],
        seed=values["seed"],
        speed=values["speed"],
        camera_rate=values["camera_rate"],
        camera_rate_moving=values["camera_rate_moving"],
        grasp=Grasp(values["grasp"]),
        noise=values["noise"],
        teacher=values["teacher"] == "scripted",
        camera=surveyed_pose(values["camera_position"], values["camera_orientation"]),
        scenes=scene_folder(values),
        driver=values["driver"],
        reminder=values["reminder"],
        robot=robot_profile(values["robot"]) if values["robot"] else None,
        camera_driver=camera_profile(values["camera"]) if values["camera"] else None,
    )


def scene_folder(values: Mapping[str, Any]) -> Path:
    """Where the scene files are; raises MbdError when that is this package's and it is not in the overlay."""
    return Path(values["scene_dir"]) if values["scene_dir"] else own_config()


def own_config() -> Path:
    """Where this package keeps its scene files; raises MbdError when it is not in the overlay."""
    try:
        return Path(get_package_share_directory("mbd_cell")) / "config"
    except PackageNotFoundError as error:
        raise MbdError("package mbd_cell is not in the overlay; source env.sh, or give scene_dir") from error
