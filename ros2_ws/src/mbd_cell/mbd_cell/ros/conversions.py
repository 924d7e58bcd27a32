"""Between the cell's values and ROS messages."""

from __future__ import annotations

import array
import math
from collections.abc import Sequence

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Vector3
from mbd_model.errors import MbdError
from mbd_model.ros.conversions import ROLE_TO_CODE, stamp_to_msg
from mbd_msgs.msg import AcceptableTargets, CellTruth, ObjectTruth, Speech
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2, PointField
from std_msgs.msg import Header

from mbd_cell.arm.kinematics import DownwardToolPose
from mbd_cell.cell import DOWN, Cell
from mbd_cell.outcome import ObjectState
from mbd_cell.physics import simulation
from mbd_cell.physics.camera import INTRINSICS, Frame
from mbd_cell.teacher.script import Word

LEVEL = 0.2  # by which a goal's x axis, which is taken as level, may rise per metre
BASE_FRAME = "j2n6s300_link_base"
CAMERA_FRAME = "camera_color_optical_frame"
JOINT_NAMES = [f"j2n6s300_joint_{i}" for i in range(1, 7)] + [f"j2n6s300_joint_finger_{i}" for i in range(1, 4)]


def _bytes(values: NDArray[np.generic]) -> array.array[int]:
    # The one type of data that rclpy takes without looking at each element.
    data = array.array("B")
    data.frombytes(np.ascontiguousarray(values).data.cast("B"))
    return data


def pose_to_msg(pose: simulation.Pose) -> Pose:
    """A pose in the base frame."""
    (x, y, z), (i, j, k, w) = pose.position, pose.quaternion
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w))


def tool_pose_to_msg(cell: Cell) -> PoseStamped:
    """The tool as the arm's driver states it."""
    return PoseStamped(
        header=Header(stamp=stamp_to_msg(cell.time_ns), frame_id=BASE_FRAME), pose=pose_to_msg(cell.simulation.tool)
    )


def joint_state_to_msg(cell: Cell) -> JointState:
    """Six arm joints and three fingers [rad, rad/s] as the arm's driver names them."""
    physics = cell.simulation
    return JointState(
        header=Header(stamp=stamp_to_msg(cell.time_ns)),
        name=JOINT_NAMES,
        position=[float(v) for v in (*physics.arm_joints, *physics.finger_joints)],
        velocity=[float(v) for v in physics.joint_speeds],
    )


def object_states_from_truth(truth: CellTruth) -> dict[str, ObjectState]:
    """Every object of a truth, by name."""
    return {o.name: ObjectState(pose_from_msg(o.pose), (o.size.x, o.size.y, o.size.z)) for o in truth.objects}


def pose_from_msg(msg: Pose) -> simulation.Pose:
    """A pose."""
    p, q = msg.position, msg.orientation
    return simulation.Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def truth_to_msg(cell: Cell, frame: str = BASE_FRAME) -> CellTruth:
    """What stands on the table and which mapping is right."""
    physics = cell.simulation
    objects = []
    for name, thing in physics.objects.items():
        x, y, z = thing.size
        objects.append(
            ObjectTruth(
                name=name,
                pose=pose_to_msg(physics.object_pose(name)),
                size=Vector3(x=x, y=y, z=z),
                has_hue=thing.hue is not None,
                hue=math.nan if thing.hue is None else thing.hue,
            )
        )
    return CellTruth(
        header=Header(stamp=stamp_to_msg(cell.time_ns), frame_id=frame),
        task=cell.scenes.task,
        role=ROLE_TO_CODE[cell.role],
        seed=cell.seed,
        objects=objects,
        solution=[
            AcceptableTargets(source_name=source, target_names=list(targets))
            for source, targets in cell.scenes.solution.items()
        ],
    )


def speech_to_msg(word: Word, time_ns: int) -> Speech:
    """A word spoken at that time."""
    return Speech(header=Header(stamp=stamp_to_msg(time_ns)), word=int(word))


def camera_info_to_msg(time_ns: int) -> CameraInfo:
    """The pinhole of the rendered images."""
    k = INTRINSICS
    return CameraInfo(
        header=Header(stamp=stamp_to_msg(time_ns), frame_id=CAMERA_FRAME),
        width=k.width,
        height=k.height,
        distortion_model="plumb_bob",
        d=[0.0] * 5,
        k=[k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[k.fx, 0.0, k.cx, 0.0, 0.0, k.fy, k.cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def color_to_msg(frame: Frame, time_ns: int) -> Image:
    """Colour, rgb8."""
    return _image(frame.color, "rgb8", 3, time_ns)


def depth_to_msg(frame: Frame, time_ns: int) -> Image:
    """Depth, 16UC1 [mm], 0 = no return."""
    return _image(frame.depth_mm, "16UC1", 2, time_ns)


def _image(pixels: NDArray[np.generic], encoding: str, pixel_bytes: int, time_ns: int) -> Image:
    height, width = pixels.shape[:2]
    return Image(
        header=Header(stamp=stamp_to_msg(time_ns), frame_id=CAMERA_FRAME),
        height=height,
        width=width,
        encoding=encoding,
        step=width * pixel_bytes,
        data=_bytes(pixels),
    )


def cloud_to_msg(frame: Frame, time_ns: int) -> PointCloud2:
    """Organized cloud x, y, z [m, optical frame], rgb packed as a float32; no return = NaN."""
    height, width = frame.depth.shape
    color = frame.color.astype(np.uint32)
    packed = (color[..., 0] << 16) | (color[..., 1] << 8) | color[..., 2]
    values = np.concatenate((frame.points, packed.view(np.float32)[..., None]), axis=-1)
    names: Sequence[str] = ("x", "y", "z", "rgb")
    return PointCloud2(
        header=Header(stamp=stamp_to_msg(time_ns), frame_id=CAMERA_FRAME),
        height=height,
        width=width,
        fields=[PointField(name=n, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, n in enumerate(names)],
        point_step=16,
        row_step=16 * width,
        data=_bytes(values),
        is_dense=False,
    )


def goal_from_msg(target: PoseStamped) -> DownwardToolPose:
    """The tool pose a motion goal asks for.

    Raises:
        MbdError: another frame than the base's, or the tool does not point down.
    """
    if target.header.frame_id not in ("", BASE_FRAME):
        raise MbdError(f"goal in frame '{target.header.frame_id}'; this cell takes goals in '{BASE_FRAME}'")
    return downward_goal(target.pose)


def downward_goal(pose: Pose) -> DownwardToolPose:
    """The tool pose that a pose in the base frame asks for; raises MbdError when the tool does not point down.

    A tilt about the tool's x axis is taken.
    """
    q = pose.orientation
    down, level = 1.0 - 2.0 * (q.x * q.x + q.y * q.y), 2.0 * (q.x * q.z - q.w * q.y)
    if not (down < DOWN and abs(level) < LEVEL):
        raise MbdError(
            f"goal orientation ({q.x:.2f}, {q.y:.2f}, {q.z:.2f}, {q.w:.2f}) does not point the tool down, nor tilts it "
            "by less than 0.45 rad about its x axis; z of the tool runs along the fingers, so take (cos a, sin a, 0, "
            "0) for a turn of 2 a about the vertical"
        )
    # The tool's x axis in the base frame; its heading is the yaw. The tilt is the rise of its y axis.
    yaw = math.atan2(2 * (q.x * q.y + q.w * q.z), 1 - 2 * (q.y * q.y + q.z * q.z))
    tilt = math.atan2(2.0 * (q.y * q.z + q.w * q.x), -down)
    p = pose.position
    return DownwardToolPose(p.x, p.y, p.z, yaw, tilt)
