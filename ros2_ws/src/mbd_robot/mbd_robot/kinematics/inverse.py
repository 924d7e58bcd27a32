"""Inverse kinematics within the joints' limits: mink's differential steps on the arm's chain."""

from __future__ import annotations

from collections.abc import Iterable

import mink
import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_robot.geometry import RobotToolPose
from mbd_robot.kinematics.chain import TOOL, ArmChain

POSITION, ROTATION = 1e-3, 1e-2  # [m], [rad] within which the tool is where it is wanted
ITERATIONS = 80
STEP = 1.0  # [s] mink integrates velocities; with 1 a step is a Gauss-Newton step
LARGEST = 0.25  # [rad] of a joint in one step


class OutOfReachError(MbdError):
    """A tool pose that the arm does not take within its joints' limits.

    Attributes:
        short: [m] how near it came.
    """

    def __init__(self, text: str, short: float) -> None:
        super().__init__(text)
        self.short = short


class InverseKinematics:
    """Finds joint angles for tool poses, each near those before."""

    def __init__(self, chain: ArmChain) -> None:
        self._chain = chain
        self._configuration = mink.Configuration(chain.model)
        self._task = mink.FrameTask(TOOL, "site", position_cost=1.0, orientation_cost=0.3, lm_damping=1e-6)
        self._limits = [mink.ConfigurationLimit(chain.model)]

    def solve(self, target: RobotToolPose, start: NDArray[np.float64]) -> NDArray[np.float64]:
        """Joint angles (J,) [rad] that put the tool there, near ``start`` (J,).

        Raises:
            OutOfReachError: there are none within 1 mm and 10 mrad that lead there from ``start``.
        """
        chain, task = self._chain, self._task
        x, y, z, w = target.quaternion
        task.set_target(mink.SE3(np.concatenate(((w, x, y, z), target.position))))
        q = np.array(chain.data.qpos)
        q[chain.qpos] = np.clip(start, chain.low, chain.high)
        error = np.full(6, np.inf)
        for _ in range(ITERATIONS):
            self._configuration.update(q)
            error = task.compute_error(self._configuration)
            if np.linalg.norm(error[:3]) < 0.1 * POSITION and np.linalg.norm(error[3:]) < 0.1 * ROTATION:
                return np.array(q[chain.qpos])
            try:
                velocity = mink.solve_ik(
                    self._configuration, [task], STEP, "daqp", damping=1e-6, limits=self._limits
                )  # fmt: skip
            except mink.NoSolutionFound:
                break
            largest = float(np.abs(velocity).max())
            step = velocity * min(1.0, LARGEST / max(largest, 1e-9))
            q = self._configuration.integrate(step, STEP)
        short = float(np.linalg.norm(error[:3]))
        if short < POSITION and np.linalg.norm(error[3:]) < ROTATION:
            return np.array(q[chain.qpos])
        where = ", ".join(f"{v:.3f}" for v in target.position)
        raise OutOfReachError(
            f"the arm does not reach the tool position ({where}) m with the hand so turned: {short:.3f} m short; "
            "move the objects nearer, or the robot",
            short,
        )

    def follow(self, targets: Iterable[RobotToolPose], start: NDArray[np.float64]) -> NDArray[np.float64]:
        """Joint angles (N, J) [rad] for poses along a way, each near the one before.

        Raises:
            OutOfReachError: one of them is out of reach.
        """
        joints, found = np.array(start, dtype=np.float64), []
        for target in targets:
            joints = self.solve(target, joints)
            found.append(joints)
        return np.array(found)
