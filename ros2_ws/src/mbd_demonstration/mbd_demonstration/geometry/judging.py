"""Which closings and openings are no steps, how they are told, and how near a tie the object of a step was."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose, ToolTrajectory

REGRASPED = "'{}' was let go where it had been grasped: taken as a re-grasp, not as a step"
PUSHED = (
    "the closed hand moved along the table beside or against '{}' and never rose: taken as a push, not as a step; "
    "where it now stands was not followed"
)
IN_THE_AIR = "'{}' was let go {:.2f} m above everything below it: taken as handed over in the air, not as placed"
DROPPED = (
    "'{}' was let go {:.2f} m above what is below it, too high to be put onto that (onto_clearance) and too low to be "
    "handed over (drop): taken as placed by itself; change the step's object if it was put onto something"
)
MAYBE_PUSHED = (
    "'{}' was grasped {:.0f} mm beside it and never rose: taken as carried along the table; if the closed hand only "
    "pushed it, delete the step"
)
# Fingers that close this share of a range in which others rested half way hold nothing thicker than THIN [m]; a tool
# this far from a thing is not around it [m].
SHUT, THIN, BESIDE = 0.97, 0.02, 0.008


@dataclasses.dataclass(frozen=True)
class Hold:
    """The object in the gripper.

    Attributes:
        object_id: of the object.
        stamp: since when [s].
        grasp: where the tool was then.
        level: share of the fingers' range at which they rest on it; NaN where it is not known.
        distance: of the tool to it as it was grasped [m].
        taken_again: its PICK was a step before.
    """

    object_id: str
    stamp: float
    grasp: ToolPose
    level: float = math.nan
    distance: float = 0.0
    taken_again: bool = False


def pushed(
    workspace: TrackedObjects, held: Hold, trajectory: ToolTrajectory, stamp: float, config: StepSegmentationConfig
) -> bool:
    """Whether a closed hand only pushed: it never rose, and it was shut, or closed beside the object."""
    if held.taken_again or trajectory.rise_above(float(held.grasp.position[2]), held.stamp, stamp) >= config.lift:
        return False
    narrowest = min(workspace[held.object_id].size[:2])
    return held.distance > BESIDE or (held.level >= SHUT and narrowest > THIN)


def remarks(
    held: Hold, trajectory: ToolTrajectory, stamp: float, fall: float, config: StepSegmentationConfig
) -> tuple[str, ...]:
    """What may be otherwise about a place that was taken for one, a sentence each.

    Args:
        held: what was let go.
        trajectory: path of the tool.
        stamp: when it was let go [s].
        fall: [m] how high above what is below it, if it was put onto nothing; else 0.
        config: distances that decide.
    """
    never_up = trajectory.rise_above(float(held.grasp.position[2]), held.stamp, stamp) < config.lift
    shut = math.isnan(held.level) or held.level >= SHUT  # for all that is known
    found: tuple[str, ...] = ()
    if never_up and shut and not held.taken_again and held.distance > config.distance_noise:
        found += (MAYBE_PUSHED.format(held.object_id, 1e3 * held.distance),)
    if fall > config.onto_clearance:
        found += (DROPPED.format(held.object_id, fall),)
    return found


def tie(
    workspace: TrackedObjects, tool: ToolPose, order: list[tuple[float, str]], config: StepSegmentationConfig
) -> float:
    """Probability that the second of two (distance [m], id) was meant, both being as far as ``distance_noise`` tells.

    With the tool inside both boxes the nearer centre was taken, and decides here too.
    """
    if len(order) < 2:
        return 0.0
    (first, one), (second, other) = order
    margin = second - first
    if second == 0.0:
        ways = [float(np.linalg.norm(tool.position - np.asarray(workspace[k].centroid))) for k in (one, other)]
        margin = ways[1] - ways[0]
    doubt = 0.5 * math.erfc(max(margin, 0.0) / (2.0 * max(config.distance_noise, 1e-9)))
    return float(np.float32(doubt))  # as the message holds it
