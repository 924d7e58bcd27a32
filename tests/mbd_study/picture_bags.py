"""Bags with pictures of a table and of a person beside it, in each form that a camera sends."""

from __future__ import annotations

from array import array
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import matplotlib
import numpy as np
from mbd_bag.session.session_facts import parameter_facts
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import MessageWriter
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import pose_from_quaternion
from mbd_perception.segmentation.workspace import Workspace
from mbd_study.sharing.pictures.volume import TableVolume
from mbd_study.sharing.rules import SharedPictures
from mbd_study.sharing.shared_copy import Omissions, shared_copy
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2, PointField

HEIGHT, WIDTH = 480, 640
POSITION, ORIENTATION = (0.45, 0.0, 0.95), (0.5**0.5, -(0.5**0.5), 0.0, 0.0)  # straight above, robot below
CAMERA = Intrinsics(540.0, 540.0, 319.5, 239.5, WIDTH, HEIGHT)
WORKSPACE = Workspace((0.25, 0.65), (-0.4, 0.4), (-0.05, 0.5))
PARAMETERS = {
    "base_frame": "base_link",
    "camera_pose": "parameter",
    "camera_position": list(POSITION),
    "camera_orientation": list(ORIENTATION),
    "workspace_x": [0.25, 0.65],
    "workspace_y": [-0.4, 0.4],
    "workspace_z": [-0.05, 0.5],
}
VOLUME = TableVolume(CAMERA, pose_from_quaternion(POSITION, ORIENTATION), WORKSPACE, "camera", "base_link")
HEAD = (slice(150, 310), slice(60, 200))  # over the table, within the workspace
LOOKER_ON = (slice(0, 110), slice(300, 400))  # beyond the table's edge
TABLE = (slice(130, 350), slice(300, 540))  # nothing but the table, in the workspace
FIRST = "/camera/color/image_raw"
FRAMES = 1_000_000_000 + 200_000_000 * np.arange(2)


@cache
def face(height: int, width: int) -> NDArray[np.uint8]:
    """A portrait in the public domain that matplotlib ships (Rear Admiral Grace Hopper), RGB."""
    path = Path(matplotlib.get_data_path()) / "sample_data" / "grace_hopper.jpg"
    picture = cv2.imread(str(path))[60:430, 90:400, ::-1]
    return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA))


@cache
def scene() -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """RGB and depth [m]: a table with print, a head over it, upside down, and somebody beyond its edge."""
    color = np.random.default_rng(1).integers(150, 200, (HEIGHT, WIDTH, 3), np.uint8)
    depth = np.full((HEIGHT, WIDTH), 0.95, np.float32)
    depth[:110] = 1.6
    color[HEAD] = face(160, 140)[::-1, ::-1]
    depth[HEAD] = 0.6
    color[LOOKER_ON] = face(110, 100)
    return color, depth


def stamped(message: Any, stamp: int, frame: str = "camera") -> Any:
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(int(stamp), 10**9)
    return message


def image(pixels: NDArray[Any], encoding: str, stamp: int, frame: str = "camera", padding: int = 0) -> Image:
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(len(pixels), -1)
    data = np.pad(rows, ((0, 0), (0, padding)), constant_values=7)
    shape = {"height": pixels.shape[0], "width": pixels.shape[1], "step": data.shape[1], "encoding": encoding}
    return stamped(Image(data=array("B", data.tobytes()), **shape), stamp, frame)


def compressed(pixels: NDArray[Any], form: str, ending: str, stamp: int, header: bytes = b"") -> CompressedImage:
    data = array("B", header + cv2.imencode(ending, pixels)[1].tobytes())
    return stamped(CompressedImage(format=form, data=data), stamp)


@cache
def records(frame: str) -> bytes:
    """The scene's points, x, y, z [m] and packed rgb each."""
    color, depth = scene()
    columns, rows = CAMERA.rays()
    points = np.stack([columns * depth, rows * depth, depth], axis=-1)
    if frame != "camera":
        points = VOLUME.pose.to_base(points.reshape(-1, 3)).reshape(points.shape)
    kept = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    kept[..., :3] = points
    kept[..., 3] = (color.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)).view(np.float32)
    return kept.tobytes()


def cloud(stamp: int, frame: str = "camera", organized: bool = True) -> PointCloud2:
    fields = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in enumerate(("x", "y", "z", "rgb"))]
    height, width = (HEIGHT, WIDTH) if organized else (1, HEIGHT * WIDTH)
    made = PointCloud2(height=height, width=width, fields=fields, point_step=16, row_step=16 * width)
    made.data = array("B", records(frame))
    return stamped(made, stamp, frame)


def yuyv(color: NDArray[np.uint8]) -> NDArray[np.uint8]:
    yuv = cv2.cvtColor(color, cv2.COLOR_RGB2YUV)
    packed = yuv[..., :2].copy()
    packed[:, 1::2, 1] = yuv[:, ::2, 2]
    return packed


def pictures(stamp: int) -> dict[str, Any]:
    """One of each kind, by topic."""
    color, depth = scene()
    millimetres = np.round(1000 * depth).astype(np.uint16)
    return {
        "/camera/color/image_raw": image(color, "rgb8", stamp, padding=8),
        "/camera/color/image_raw/compressed": compressed(color[..., ::-1], "rgb8; jpeg compressed bgr8", ".jpg", stamp),
        "/camera/color/png": compressed(color[..., ::-1], "png", ".png", stamp),
        "/camera/grey": image(color[..., 1], "mono8", stamp),
        "/camera/yuyv": image(yuyv(color), "yuv422_yuy2", stamp),
        "/camera/depth/image_raw": image(millimetres, "16UC1", stamp),
        "/camera/depth/metres": image(depth, "32FC1", stamp),
        "/camera/depth/image_raw/compressedDepth": compressed(
            millimetres, "16UC1; compressedDepth png", ".png", stamp, bytes(12)
        ),
        "/camera/points": cloud(stamp),
        "/points_in_base": cloud(stamp, "base_link", organized=False),
    }


def written(folder: Path, messages: list[tuple[str, Any]], parameters: dict[str, Any] = PARAMETERS) -> Bag:
    info = CameraInfo(height=HEIGHT, width=WIDTH, k=[540.0, 0.0, 319.5, 0.0, 540.0, 239.5, 0.0, 0.0, 1.0])
    with BagWriter(folder) as bag:
        bag.add_facts({"session": "p07_sorting", "participant": "p07", **parameter_facts("/perception", parameters)})
        writer = MessageWriter(bag)
        writer.write("/camera/color/camera_info", stamped(info, 1), 10**9)
        for number, (topic, message) in enumerate(messages):
            writer.write(topic, message, 10**9 + number)
    return Bag(folder)


def shared(bag: Bag, folder: Path, kept: SharedPictures = SharedPictures.TABLE) -> tuple[Bag, Omissions]:
    omitted = shared_copy(bag, folder, session="a01_01", participant="a01", pictures=kept)
    return Bag(folder), omitted
