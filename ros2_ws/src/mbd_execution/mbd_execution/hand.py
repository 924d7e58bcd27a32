"""The hand's measures, and how much room its open fingers have between the objects."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from mbd_model.geometry.boxes import distance_to_footprint
from mbd_model.objects import SceneObject

from mbd_execution.boxes import top
from mbd_execution.goals import ToolGoal, turn_between, turned


@dataclass(frozen=True)
class HandConfig:
    """A three-finger hand seen from its tool point, and the distances to keep; the defaults are a Jaco's.

    Finger 1 is on the tool's -y side, fingers 2 and 3 on its +y side: the hand closes along the tool's y axis.

    Attributes:
        fingertip_drop: [m] fingertips reach this far below the tool point when they close.
        table_gap: [m] they keep from what they close above.
        thinnest: [m] an object thinner than this fits through between closed fingertips.
        thin_shift: [m] such a one is taken this far off the tool's axis, on the side of fingers 2 and 3.
        widest: [m] an object wider than this is not taken around, but by its rim.
        finger_out, finger_side, finger_radius: [m] where an open finger is: out from the tool's axis, sideways (fingers
            2 and 3), and how thick.
        grasp_depth: [m] tool point below an object's top, at most; and for a rim.
        rim_depth: [m]
        rim_in: [m] a rim is taken this far inside the box's side: where the wall is at the height of the fingertips.
        rim_tilt: [rad] the hand leans outwards by this where the rim is that of a wall that does so.
        release_gap: [m] between an object's bottom and what it is released onto.
        rim_gap: [m] fingers keep above the rim of what they put something into, unless the complete hand fits in.
        hand_radius: [m] half of what the open hand takes up sideways.
        clearance: [m] between what is carried and what it is carried over.
        hover: [m] above a grasp or release before going straight down.
        highest: [m] the arm reaches with the hand down at most this high.
        look_from: tool position (x, y, z) [m, robot base frame] and turn [rad] that are out of the camera's view.
        hand_zone: (x_min, x_max, y_min, y_max) [m, robot base frame] of the teacher's hands, at any height, which
            neither the tool nor what it holds passes over; all 0: none.
    """

    fingertip_drop: float = 0.014
    table_gap: float = 0.002
    thinnest: float = 0.024
    thin_shift: float = 0.004
    widest: float = 0.095
    finger_out: float = 0.070
    finger_side: float = 0.030
    finger_radius: float = 0.016
    grasp_depth: float = 0.022
    rim_depth: float = 0.008
    rim_in: float = 0.012
    rim_tilt: float = 0.28
    release_gap: float = 0.005
    rim_gap: float = 0.008
    hand_radius: float = 0.082
    clearance: float = 0.05
    hover: float = 0.07
    highest: float = 0.40
    look_from: tuple[float, float, float, float] = (0.15, -0.45, 0.35, 0.0)
    hand_zone: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


def room(goal: ToolGoal, others: Iterable[SceneObject], hand: HandConfig) -> float:
    """Smallest distance [m] from an open finger at the goal to another object that is as high; below 0 they touch."""
    fingers = [(0.0, -hand.finger_out), (-hand.finger_side, hand.finger_out), (hand.finger_side, hand.finger_out)]
    least = math.inf
    for other in others:
        if top(other) < goal.z - hand.fingertip_drop:
            continue
        for finger in fingers:
            x, y = in_base(goal, finger)
            least = min(least, distance_to_footprint((x, y, goal.z), other) - hand.finger_radius)
    return least


def in_base(goal: ToolGoal, point: tuple[float, float]) -> tuple[float, float]:
    """A point (x, y) [m] of the tool's frame as (x, y) in the base frame: the tool's y axis points the other way."""
    dx, dy = turned(point[0], -point[1], goal.yaw)
    return goal.x + dx, goal.y + dy


def roomiest(goals: Iterable[ToolGoal], others: Iterable[SceneObject], hand: HandConfig, enough: float) -> ToolGoal:
    """The first of the goals, best first, at which the fingers have enough room [m]; else the one with the most."""
    around = tuple(others)
    choices = [(room(goal, around, hand), goal) for goal in goals]
    for space, goal in choices:
        if space >= enough:
            return goal
    return max(choices, key=lambda choice: choice[0])[1]


def nearest_yaw(yaw: float, reference: float, period: float = 2 * math.pi) -> float:
    """The yaw [rad] that means the same after ``period`` and is nearest to the reference."""
    return reference + turn_between(reference, yaw, period)
