"""The parameters of step segmentation, with the geometry that sets their defaults."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from mbd_model.errors import MbdError


@dataclass(frozen=True)
class StepSegmentationConfig:
    """How steps are read off a trajectory and its gripper events.

    Attributes:
        grasp_reach: [m] a closing takes the nearest object whose surface is at most this far from the tool point;
            farther away the gripper closed on nothing. The tool point lies between the fingertips, which are as long
            as this.
        onto_margin: [m] the held object is put onto another one when its centre is over that one's footprint, or at
            most this far beside it. An object put *beside* another keeps its own half width away from it, and one
            whose centre is farther out would tip over: the margin covers what pose and perception are off.
        onto_clearance: [m] and when its bottom is at most this far above the other's top: it is not dropped from
            higher.
        regrasp_travel: [m] an object let go before it moved this far was grasped again, not carried.
        lift: [m] a gripped object is lifted at least so far; a hand that never rises pushed with its closed fingers.
        drop: [m] an object is not let go from higher above what is below it: then it was handed over in the air.
        distance_noise: [m] standard deviation of the distance between tool and object: tool pose and perception.
        max_pose_gap: [s] a gripper event needs tool poses this near in time.
    """

    grasp_reach: float = 0.08
    onto_margin: float = 0.02
    onto_clearance: float = 0.06
    regrasp_travel: float = 0.03
    lift: float = 0.03
    drop: float = 0.12
    distance_noise: float = 0.003
    max_pose_gap: float = 1.0

    def __post_init__(self) -> None:
        """Validate once; raises MbdError naming the field."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0.0):
                raise MbdError(f"segmentation parameter {field.name} is {value}; expected a finite number >= 0")
