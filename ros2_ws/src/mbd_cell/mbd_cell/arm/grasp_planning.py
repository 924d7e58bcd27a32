"""Where the tool must be to grasp an object from above, and to release it onto another one."""

from __future__ import annotations

import math

from mbd_cell.arm.kinematics import DownwardToolPose
from mbd_cell.arm.motion import angle_between
from mbd_cell.layout.scenes import ObjectSpec, Shape
from mbd_cell.layout.shapes import FLOOR, TRAY_FLOOR, TRAY_WALL, WALL, taper
from mbd_cell.physics.simulation import Pose

# Fingertips reach this far below the tool point when they close [m]; measured on the model.
FINGERTIP_BELOW_TOOL = 0.014
TABLE_CLEARANCE = 0.004
GRASP_BELOW_TOP = 0.022
RELEASE_GAP = 0.004
RIM_CLEARANCE = 0.008
# Half of what the open hand and its fingers take up sideways [m].
OPEN_HAND_RADIUS = 0.082
ROUND = frozenset({Shape.CUP, Shape.BOWL, Shape.ELLIPSOID})


def yaw_of(pose: Pose) -> float:
    """Turn of the body's x axis about the vertical [rad]."""
    x, y, z, w = pose.quaternion
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def grasp_pose(thing: ObjectSpec, pose: Pose, near_yaw: float) -> DownwardToolPose:
    """Tool pose that takes the object from above with the fingers across its shorter side.

    Args:
        thing: the object.
        pose: its centre.
        near_yaw: of the hand's possible turns the one nearest to this is taken [rad].
    """
    x, y, z = pose.position
    top, bottom = z + thing.size[2] / 2, z - thing.size[2] / 2
    height = max(top - GRASP_BELOW_TOP, bottom + FINGERTIP_BELOW_TOOL + TABLE_CLEARANCE)
    if thing.shape in ROUND:
        return DownwardToolPose(x, y, height, near_yaw)
    # Fingers close along the tool's y axis: along the object's y, or along its x when that is the shorter side.
    yaw = yaw_of(pose) + (0.0 if thing.size[1] <= thing.size[0] else math.pi / 2)
    options = [near_yaw + angle_between(near_yaw, yaw + k * math.pi) for k in (0, 1)]
    best = min(options, key=lambda option: abs(option - near_yaw))
    return DownwardToolPose(x, y, height, best)


def rest_height(held: ObjectSpec, grip: float, onto: ObjectSpec | None, onto_pose: Pose | None) -> float:
    """Height of the held object's bottom at which to release it [m].

    Args:
        held: the object in the hand.
        grip: tool height above the object's bottom [m].
        onto: what it is placed onto, None for the table.
        onto_pose: where that stands.
    """
    if onto is None or onto_pose is None:
        return RELEASE_GAP
    top = onto_pose.position[2] + onto.size[2] / 2
    bottom = onto_pose.position[2] - onto.size[2] / 2
    if not onto.hollow:
        return top + RELEASE_GAP
    opening, floor = _opening(onto)
    if max(held.size[0], held.size[1]) > 2 * opening:
        return top + RELEASE_GAP
    inside = bottom + floor + RELEASE_GAP
    if opening > OPEN_HAND_RADIUS:
        return inside
    # The fingers must not go in: they stay above the rim and the object drops the rest.
    return max(inside, top + RIM_CLEARANCE - (grip - FINGERTIP_BELOW_TOOL))


def _opening(thing: ObjectSpec) -> tuple[float, float]:
    """Half of the narrower width inside at the rim, and thickness of the floor [m]."""
    if thing.shape is Shape.TRAY:
        return min(thing.size[0], thing.size[1]) / 2 - TRAY_WALL, TRAY_FLOOR
    # A thing must pass the narrower part below to lie inside.
    share = 1.0 if thing.shape is Shape.CUP else (1 + taper(thing.shape)) / 2
    return thing.size[0] / 2 * share - WALL, FLOOR
