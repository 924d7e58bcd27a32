"""What of a camera's picture belongs to the table: perception's workspace, seen through the bag's camera."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from mbd_bag.errors import BagError
from mbd_bag.session.session_facts import recorded_parameters
from mbd_bag.storage.bag import Bag
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from mbd_perception.config import known_pose
from mbd_perception.frames.frame import FloatImage, RgbdFrame
from mbd_perception.parameters import PERCEPTION
from mbd_perception.segmentation.components import Mask
from mbd_perception.segmentation.workspace import Workspace
from numpy.typing import NDArray

WIDEST = 4.0  # [m]; a workspace wider than this is no table's
LOW_PART = 0.25  # [m] above the workspace's floor: what is kept of pictures without depth
HOLE = 0.05  # [m] from a pixel with depth to one without that is taken for the same surface
FACE = 0.12  # [m]; of the narrowest face
MOST_PIXELS = 50_000_000  # of a picture; what a damaged camera_info states takes no memory


@dataclass(frozen=True)
class TableVolume:
    """The table's working volume, and the camera that sees it.

    Attributes:
        camera: of the pictures, colour and depth alike.
        pose: camera2base.
        workspace: where objects can be [m, base frame].
        camera_frame: id of the optical frame.
        base_frame: id of the base frame.
    """

    camera: Intrinsics
    pose: CameraPose
    workspace: Workspace
    camera_frame: str = ""
    base_frame: str = ""

    def seen(self, depth: FloatImage) -> Mask:
        """Which pixels show what lies in the volume, (height, width) bool.

        Args:
            depth: (height, width) z [m, optical frame], 0 = none. A pixel without is taken for its nearest neighbour's
                surface, up to a few centimetres away.
        """
        blank = np.zeros((*depth.shape, 3), np.uint8)
        inside: Mask = self.workspace.contains(depth, RgbdFrame(blank, depth, self.camera), self.pose)
        holes = (depth <= 0).astype(np.uint8)
        if not holes.any() or holes.all():
            return inside
        far, nearest = cv2.distanceTransformWithLabels(holes, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
        by_label = np.zeros(int(nearest.max()) + 1, bool)
        by_label[nearest[holes == 0]] = inside[holes == 0]
        reach = HOLE * self.camera.fx / max(self._distances[0], 0.1)
        filled: Mask = (holes == 1) & (far <= reach) & by_label[nearest] & self._crossed(math.inf)
        return inside | filled

    @cached_property
    def seen_without_depth(self) -> Mask:
        """Which pixels look at the lower part of the volume, whatever stands before it; (height, width) bool."""
        return self._crossed(LOW_PART)

    def contains(self, points: NDArray[np.float64]) -> Mask:
        """Which of (n, 3) points [m, base frame] lie in the volume; none that is not finite."""
        limits = np.array([self.workspace.x, self.workspace.y, self.workspace.z])
        inside: Mask = np.logical_and.reduce((points > limits[:, 0]) & (points < limits[:, 1]), axis=1)
        return inside

    @property
    def face_pixels(self) -> float:
        """How wide a face in the volume is at least in the picture [px]."""
        return FACE * min(self.camera.fx, self.camera.fy) / max(self._distances[1], 0.1)

    @cached_property
    def _distances(self) -> tuple[float, float]:
        """Depth of the nearest and the farthest corner of the volume [m]."""
        space = self.workspace
        corners = np.array([(x, y, z) for x in space.x for y in space.y for z in space.z])
        depth = (corners - self.pose.position) @ self.pose.rotation[:, 2]
        return float(depth.min()), float(depth.max())

    def _crossed(self, height: float) -> Mask:
        """Which pixels' rays meet the volume up to a height above its floor [m]."""
        columns, rows = (part.astype(np.float64) for part in self.camera.rays())
        low, high = self.workspace.z
        enter: NDArray[np.float64] = np.zeros((self.camera.height, self.camera.width))
        leave = np.full_like(enter, np.inf)
        for axis, (first, last) in enumerate((self.workspace.x, self.workspace.y, (low, min(high, low + height)))):
            a, b, c = self.pose.rotation[axis]
            along = a * columns + (b * rows + c)
            along = np.where(np.abs(along) < 1e-9, 1e-9, along)
            one, other = (first - self.pose.position[axis]) / along, (last - self.pose.position[axis]) / along
            enter, leave = np.maximum(enter, np.minimum(one, other)), np.minimum(leave, np.maximum(one, other))
        crossed: Mask = enter < leave
        return crossed


def volume_of(bag: Bag) -> TableVolume:
    """The table's volume, by a bag's camera_info and perception's recorded parameters.

    Args:
        bag: of a session.

    Raises:
        BagError: it does not say where its camera stood; the text is the reason alone.
    """
    values = recorded_parameters(bag.facts, PERCEPTION)
    if not {"camera_position", "camera_orientation", "workspace_x", "workspace_y", "workspace_z"} <= set(values):
        raise BagError("the bag does not say where the camera stood")
    values = PERCEPTION.values(values)
    if values["camera_pose"] != "parameter":
        raise BagError(f"where the camera stood came from '{values['camera_pose']}', which the bag's facts do not hold")
    sides = [values[f"workspace_{axis}"] for axis in "xyz"]
    if any(not high - low <= WIDEST for low, high in sides):
        raise BagError(f"its workspace is wider than {WIDEST:.0f} m, which tells no table from a room")
    frame, camera = _camera_info(bag)
    try:
        pose = known_pose(values)
        workspace = Workspace(*((float(low), float(high)) for low, high in sides))
    except MbdError as error:
        raise BagError(str(error)) from error
    if pose is None:
        raise BagError("the bag does not say where the camera stood")
    return TableVolume(camera, pose, workspace, frame, str(values["base_frame"]))


def _camera_info(bag: Bag) -> tuple[str, Intrinsics]:
    """Frame and optics of the colour camera; raises BagError when the bag does not tell which that is."""
    topics = [t.name for t in bag.topics if t.count and t.msgtype == "sensor_msgs/msg/CameraInfo"]
    color = [name for name in topics if name.endswith("color/camera_info")]
    if len(color or topics) != 1:
        raise BagError(f"it has {len(topics)} topics of camera_info, and none tells which camera's pose is known")
    _, info = next(bag.decoded({(color or topics)[0]}))
    if max(info.binning_x, info.binning_y) > 1 or info.roi.width or info.roi.height:
        raise BagError("its camera sends a part of its picture, or binned pixels")
    if info.width * info.height > MOST_PIXELS:
        raise BagError(f"its camera_info states {info.width}x{info.height} pixels")
    try:
        camera = Intrinsics(info.k[0], info.k[4], info.k[2], info.k[5], int(info.width), int(info.height))
    except MbdError as error:
        raise BagError(str(error)) from error
    return str(info.header.frame_id), camera
