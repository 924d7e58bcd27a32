"""A goal of the tool as a timed joint trajectory: straight, by the ready pose, or round what stands there."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator

import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from mbd_robot.geometry import RobotToolPose
from mbd_robot.kinematics.chain import ArmChain
from mbd_robot.kinematics.inverse import InverseKinematics, OutOfReachError
from mbd_robot.motion.joint_search import between, connect
from mbd_robot.motion.timing import JointLimits, TimedJoints, along, joined, swing

CLOSE = 0.01  # [m] and 0.05 rad between two poses of a straight way
TURN_WEIGHT = 0.2  # [m/rad] what a turn of the hand counts along a way
LEAP = 0.6  # [rad] more than this of one joint between two poses of a way is another branch, not a way
BASE = 0.2  # [m] around the base's axis that the tool does not cross
CLEARANCE = 0.005  # [m] that links and what is held keep from table and boxes
SEARCHED = 0.01  # [m] that what is held keeps where a way is searched: between two of its points it may come nearer
HELD_LEVEL = -0.8  # cosine of the same, from which on a hand is too far from it to carry something
REGION, HIGHER = (0.25, 0.75), 0.5  # [m] from the base's axis, and above the ends, where ways are searched
SAMPLES, SEED = 600, 0  # poses towards which they are searched
DOWN = -0.9  # cosine of the hand's axis to the vertical, from which on it points down, if tilted


class BlockedError(MbdError):
    """A way that would touch something.

    Attributes:
        thing: what.
    """

    def __init__(self, text: str, thing: str) -> None:
        super().__init__(text)
        self.thing = thing


class MotionPlanner:
    """Plans for one arm.

    Args:
        chain: the arm and what stands around it.
    """

    def __init__(self, chain: ArmChain) -> None:
        self._chain = chain
        self._inverse = InverseKinematics(chain)
        arm = chain.profile.arm
        self._limits = JointLimits(np.array(arm.max_velocity), arm.max_acceleration, arm.max_jerk)
        self._ready = np.array(arm.ready)

    def plan(self, joints: NDArray[np.float64], goal: RobotToolPose, speed: float) -> TimedJoints:
        """The tool straight to its goal; from a folded arm, or where there is no straight way, by the ready pose.

        Where both are blocked, by a way that is searched in the space of the joints, the hand down and no lower than
        at its ends. The same question has the same answer.

        Args:
            joints: (J,) [rad] where the arm is.
            goal: of the tool.
            speed: [m/s]

        Raises:
            OutOfReachError: the goal cannot be reached within the joints' limits.
            BlockedError: every way touches the table or a box.
        """
        chain = self._chain
        now = chain.tool_pose(joints)
        if now.rotation.as_matrix()[2, 2] < DOWN:
            try:
                return self._straight(joints, now, goal, speed)
            except (OutOfReachError, BlockedError):
                pass
        try:
            first = self._swing(joints)
            return joined(first, self._straight(first.positions[-1], chain.tool_pose(first.positions[-1]), goal, speed))
        except (OutOfReachError, BlockedError):
            round_it = self._searched(joints, now, goal)
            if round_it is None:
                raise
            return round_it

    def direct(self, joints: NDArray[np.float64], goal: RobotToolPose, speed: float) -> TimedJoints:
        """The tool straight to its goal, and by no other way; arguments and errors as of ``plan``."""
        return self._straight(joints, self._chain.tool_pose(joints), goal, speed)

    def _straight(
        self, joints: NDArray[np.float64], now: RobotToolPose, goal: RobotToolPose, speed: float
    ) -> TimedJoints:
        if _crosses_base(now.position, goal.position):
            raise OutOfReachError("the straight way leads over the robot's own base", 0.0)
        poses = list(straight(now, goal))
        way = np.vstack((joints, self._inverse.follow(poses, joints)))
        if np.abs(np.diff(way, axis=0)).max(initial=0.0) > LEAP:
            raise OutOfReachError("there is no straight way: the arm would have to change its branch", 0.0)
        self._refuse_touching(way)
        length = np.linalg.norm(goal.position - now.position)
        turn = float((now.rotation.inv() * goal.rotation).magnitude())
        lengths = np.linspace(0.0, max(float(length), TURN_WEIGHT * turn), len(way))
        return along(way, lengths, speed, self._limits)

    def _searched(self, joints: NDArray[np.float64], now: RobotToolPose, goal: RobotToolPose) -> TimedJoints | None:
        """A way from stop to stop through the joints' space; None when none was found."""
        try:
            end = self._inverse.solve(goal, self._ready)
        except OutOfReachError:
            return None
        chain, rng = self._chain, np.random.default_rng(SEED)
        beside = self._beside(joints, end)
        allowed = min(CLEARANCE, chain.nearest(joints)[0] - 1e-4)
        lowest = min(now.position[2], goal.position[2]) - CLOSE
        upright = max(HELD_LEVEL, float(now.rotation.as_matrix()[2, 2]))

        def free(q: NDArray[np.float64]) -> bool:
            tool = chain.tool_pose(q)
            level = float(tool.rotation.as_matrix()[2, 2]) <= upright and tool.position[2] >= lowest
            return level and chain.nearest(q)[0] >= allowed and chain.held_nearest(q, beside)[0] >= SEARCHED

        def samples() -> Iterator[NDArray[np.float64]]:
            for _ in range(SAMPLES):
                radius, angle = rng.uniform(*REGION), rng.uniform(-np.pi / 2, np.pi / 2)
                height, yaw = lowest + rng.uniform(0.0, HIGHER), rng.uniform(-np.pi, np.pi)
                place = np.array((radius * np.cos(angle), radius * np.sin(angle), height))
                pose = RobotToolPose(place, np.array((np.cos(yaw / 2), np.sin(yaw / 2), 0.0, 0.0)))
                try:
                    yield self._inverse.solve(pose, self._ready if rng.random() < 0.5 else joints)
                except OutOfReachError:
                    continue

        way = connect(joints, end, samples(), free, rng)
        if way is None:
            return None
        parts = []
        for one, other in itertools.pairwise(way):
            points = np.array((one, *between(one, other)))
            lengths = np.linspace(0.0, float(np.abs(other - one).max()), len(points))
            parts.append(along(points, lengths, float(self._limits.velocity.max()), self._limits))
        timed = functools.reduce(joined, parts)
        self._refuse_touching(timed.positions)
        self._refuse_held_touching(timed.positions)
        return timed

    def _swing(self, joints: NDArray[np.float64]) -> TimedJoints:
        """To the ready pose, joints that turn without end by the shorter way."""
        endless = ~np.isfinite(self._chain.low)
        goal = np.where(endless, joints + (self._ready - joints + np.pi) % (2 * np.pi) - np.pi, self._ready)
        timed = swing(joints, goal, self._limits)
        self._refuse_touching(timed.positions)
        self._refuse_held_touching(timed.positions)
        return timed

    def _beside(self, *ends: NDArray[np.float64]) -> frozenset[str]:
        """What the thing in the hand stands on or beside at the ends of a way: that it has to come near to."""
        return frozenset().union(*(self._chain.touched_by_held(joints, SEARCHED) for joints in ends))

    def _refuse_held_touching(self, way: NDArray[np.float64]) -> None:
        """Raise BlockedError where what is held comes too near to something it is not near to at either end.

        Straight ways are the client's, who plans them for what hangs from the hand; all others are chosen here.
        """
        beside = self._beside(way[0], way[-1])
        for joints in way[1:-1]:
            distance, thing = self._chain.held_nearest(joints, beside)
            if distance < CLEARANCE:
                text = f"what is in the hand would come within {max(distance, 0.0) * 1000:.0f} mm of {thing}"
                raise BlockedError(f"{text}; clear the way, or lay the objects farther apart", thing)

    def _refuse_touching(self, way: NDArray[np.float64]) -> None:
        """Raise BlockedError where the way comes nearer to something than it began."""
        allowed = min(CLEARANCE, self._chain.nearest(way[0])[0] - 1e-4)
        for joints in way[1:]:
            distance, thing = self._chain.nearest(joints)
            if distance < allowed:
                text = f"the arm would come within {distance * 1000:.0f} mm of {thing}"
                raise BlockedError(f"{text}; clear the way, or lay the objects farther apart", thing)


def straight(now: RobotToolPose, goal: RobotToolPose) -> Iterator[RobotToolPose]:
    """Poses from ``now``, which is left out, to the goal: straight, the hand turning by the shorter way."""
    distance = float(np.linalg.norm(goal.position - now.position))
    turn = float((now.rotation.inv() * goal.rotation).magnitude())
    count = max(1, int(np.ceil(max(distance / CLOSE, turn / 0.05))))
    between = Slerp([0.0, 1.0], Rotation.from_quat(np.stack((now.quaternion, goal.quaternion))))
    for i in range(1, count + 1):
        t = i / count
        position = now.position + t * (goal.position - now.position)
        yield RobotToolPose(position, between(t).as_quat())


def _crosses_base(start: NDArray[np.float64], end: NDArray[np.float64]) -> bool:
    """Whether the tool would come nearer to the base's axis than it may, and than it is at either end."""
    way = end[:2] - start[:2]
    t = float(np.clip(-start[:2] @ way / max(float(way @ way), 1e-12), 0.0, 1.0))
    nearest = float(np.linalg.norm(start[:2] + t * way))
    return nearest < min(BASE, float(np.linalg.norm(start[:2])) - 1e-3, float(np.linalg.norm(end[:2])) - 1e-3)
