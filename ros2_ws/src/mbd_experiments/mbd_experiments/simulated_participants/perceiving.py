"""How the simulated study sees: the perception node's defaults under the cell's own parameter file, as in a session."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from mbd_model.errors import MbdError
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig
from mbd_perception.ros.parameters import PARAMETERS
from mbd_perception.segmentation.components import JumpConfig
from mbd_perception.segmentation.plane import PlaneConfig
from mbd_perception.segmentation.segment import SegmentationConfig
from mbd_perception.segmentation.workspace import Workspace


def perception_parameters(cell_config: Path) -> dict[str, Any]:
    """The perception node's parameters by name.

    Args:
        cell_config: folder of the cell's configuration with ``camera.yaml``.

    Raises:
        MbdError: the file cannot be used.
    """
    values: dict[str, Any] = {spec.name: spec.default for spec in PARAMETERS}
    path = cell_config / "camera.yaml"
    try:
        values |= yaml.safe_load(path.read_text(encoding="utf-8"))["/**"]["ros__parameters"]
    except (OSError, yaml.YAMLError, KeyError, TypeError) as error:
        raise MbdError(f"{path} is no parameter file with a section '/**': {error}") from error
    return values


def perception_config(values: dict[str, Any], knowledge: Path) -> ObserveConfig:
    """What the perception node makes of its parameters.

    Raises:
        MbdError: the knowledge base cannot be used.
    """
    (x_min, x_max), (y_min, y_max), (z_min, z_max) = (values[f"workspace_{axis}"] for axis in "xyz")
    noise = values["depth_noise"]
    segmentation = SegmentationConfig(
        plane=PlaneConfig(noise=noise),
        jump=JumpConfig(noise=noise),
        workspace=Workspace((x_min, x_max), (y_min, y_max), (z_min, z_max)),
        min_height=values["min_height"],
        min_area=values["min_area"],
    )
    return ObserveConfig(load_knowledge(knowledge), segmentation, frame_id=values["base_frame"])
