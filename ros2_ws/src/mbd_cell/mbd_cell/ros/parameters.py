"""The cell node's parameters, each declared once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from mbd_cell.physics.camera_pose import CELL_CAMERA_ORIENTATION, CELL_CAMERA_POSITION, surveyed_pose


@dataclass(frozen=True)
class CellParameters:
    """The parameters as the node uses them; units in ``declare``."""

    task: str
    seed: int
    speed: float
    camera_rate: float
    camera_rate_moving: float
    noise: bool
    teacher: bool
    camera: CameraPose
    scenes: Path
    driver: str
    reminder: float

    def scene_file(self, task: str) -> Path:
        """Where that task's scenes are."""
        return self.scenes / f"{task}.yaml"


def declare(node: Node) -> CellParameters:
    """Declare and read all parameters.

    Raises:
        MbdError: a value that cannot be used.
    """

    def get(name: str, default: Any, text: str, low: float | None = None, high: float | None = None) -> Any:
        descriptor = ParameterDescriptor(description=text, read_only=True)
        if low is not None and high is not None:
            if isinstance(default, int):
                descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
            else:
                descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        return node.declare_parameter(name, default, descriptor).value

    teacher = get("teacher", "scripted", "Who demonstrates: 'scripted', or 'none' for an operator of the actions.")
    if teacher not in ("scripted", "none"):
        raise MbdError(f"parameter teacher is '{teacher}'; it must be 'scripted' or 'none'")
    folder = get("scene_dir", "", "Folder of the scene files; '' is this package's config folder.")
    return CellParameters(
        task=get("task", "sorting", "Name of the scene file (without .yaml) to lay."),
        seed=get("seed", 1, "Of every random choice: layout, guiding hand, noise.", 0, 2**31 - 1),
        speed=get("speed", 1.0, "Simulated over wall time while something moves; 0: as fast as it can.", 0.0, 1000.0),
        camera_rate=get("camera_rate", 4.0, "Images a simulated second while nothing moves.", 0.05, 30.0),
        camera_rate_moving=get("camera_rate_moving", 0.5, "Images a simulated second while the arm moves.", 0.05, 30.0),
        noise=get("noise", True, "Structured-light depth noise and colour grain."),
        teacher=teacher == "scripted",
        camera=surveyed_pose(
            get("camera_position", list(CELL_CAMERA_POSITION), "Optical centre x, y, z [m, base frame]."),
            get("camera_orientation", list(CELL_CAMERA_ORIENTATION), "camera2base quaternion x, y, z, w."),
        ),
        scenes=Path(folder) if folder else own_config(),
        driver=get("driver", "j2n6s300_driver", "Namespace of the arm driver's topics."),
        reminder=get(
            "reminder", 3.0, "After so many wall-clock seconds unanswered the teacher repeats a word.", 0.5, 60.0
        ),
    )


def own_config() -> Path:
    """Where this package keeps its scene files; raises MbdError when it is not in the overlay."""
    try:
        return Path(get_package_share_directory("mbd_cell")) / "config"
    except PackageNotFoundError as error:
        raise MbdError("package mbd_cell is not in the overlay; source env.sh, or give scene_dir") from error
