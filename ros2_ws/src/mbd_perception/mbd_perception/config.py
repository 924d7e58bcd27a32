"""What perception is given as the algorithms' config: for the node, a computation from a bag and a simulated study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbd_model.camera.parameters import camera_pose
from mbd_model.camera.pose import CameraPose

from mbd_perception.features.knowledge import KnowledgeBase
from mbd_perception.features.measure import ObserveConfig
from mbd_perception.segmentation.components import JumpConfig
from mbd_perception.segmentation.segment import SegmentationConfig
from mbd_perception.segmentation.table.plane import PlaneConfig
from mbd_perception.segmentation.workspace import Workspace
from mbd_perception.segmenters.segmenter import OWN, load_segmenter


def observe_config(values: Mapping[str, Any], knowledge: KnowledgeBase) -> ObserveConfig:
    """How scenes are seen.

    Args:
        values: of the parameters of ``PERCEPTION``, by name.
        knowledge: the base that the parameter ``knowledge`` names; where that file is differs from caller to caller.

    Raises:
        MbdError: values that cannot go together, or a segmenter that cannot be loaded.
    """
    noise = values["depth_noise"]
    (x_low, x_high), (y_low, y_high), (z_low, z_high) = (values[f"workspace_{axis}"] for axis in "xyz")
    return ObserveConfig(
        knowledge=knowledge,
        segmentation=SegmentationConfig(
            plane=PlaneConfig(noise=noise),
            jump=JumpConfig(noise=noise),
            workspace=Workspace((x_low, x_high), (y_low, y_high), (z_low, z_high)),
            min_height=values["min_height"],
            min_area=values["min_area"],
        ),
        frame_id=values["base_frame"],
        segmenter=None if values["segmenter"] == OWN else load_segmenter(values["segmenter"]),
    )


def known_pose(values: Mapping[str, Any]) -> CameraPose | None:
    """camera2base by parameter, None where it is to be worked out from the table; raises MbdError for one that is none.

    A pose that came from tf2 is not among the values: what stands in the parameters is taken for it.
    """
    return None if values["camera_pose"] == "table" else camera_pose(values)
