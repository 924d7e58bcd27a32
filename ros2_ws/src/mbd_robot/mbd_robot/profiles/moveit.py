"""How MoveIt 2 is asked for motions: a part of a robot's profile."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_model.errors import MbdError


@dataclass(frozen=True)
class MoveItProfile:
    """A MoveGroup as its configuration has it.

    Attributes:
        group: planning group of the arm, without its hand, as the SRDF names it.
        planners: pipeline/planner in the order in which they are tried; a pipeline's default planner is `pipeline/`.
        full_speed: [m/s] of the tool at velocity scaling 1: Pilz' cartesian_limits.max_trans_vel.
        acceleration: share of the largest acceleration, 0..1.
        planning_time: [s] each planner may take.
        touch_links: links of the hand and its fingers, as the URDF names them: what is held may touch them. None:
            MoveIt is not told what is held.
    """

    group: str
    planners: tuple[str, ...] = (
        "pilz_industrial_motion_planner/LIN",
        "pilz_industrial_motion_planner/PTP",
        "ompl/",
    )
    full_speed: float = 1.0
    acceleration: float = 0.1
    planning_time: float = 5.0
    touch_links: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """A group and a planner are needed, and numbers that mean something."""
        if not self.group:
            raise MbdError("group is empty; expected the SRDF's planning group of the arm")
        wrong = next((p for p in self.planners if "/" not in p), None)
        if wrong is not None or not self.planners:
            raise MbdError(f"planners has '{wrong or ''}'; expected pipeline/planner, as ompl/RRTConnectkConfigDefault")
        if not 0 < self.acceleration <= 1 or not self.full_speed > 0 or not self.planning_time > 0:
            raise MbdError("full_speed and planning_time must be above 0, acceleration within 0..1")
