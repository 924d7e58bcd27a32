"""Inverse kinematics of the arm, the hand down or tilted: damped least squares on MuJoCo's Jacobian."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_cell.physics.robot_model import CellRobot
from mbd_cell.physics.robots import JACO

# Tool at (0.4, 0, 0.3), hand down, yaw 0, elbow up: from here every place of the table is reached without a jump.
HOME = JACO.arm.home


class UnreachableError(MbdError):
    """A tool pose the arm cannot take; the text gives it and how near the arm came."""


@dataclass(frozen=True)
class DownwardToolPose:
    """A tool pose with the fingers pointing down, or tilted from there.

    Attributes:
        x, y, z: [m, base frame]
        yaw: [rad] turn of the hand about the vertical.
        tilt: [rad] turn about the tool's x axis, its fingertips towards the tool's +y side.
    """

    x: float
    y: float
    z: float
    yaw: float
    tilt: float = 0.0

    @property
    def position(self) -> NDArray[np.float64]:
        """(3,) [m]."""
        return np.array([self.x, self.y, self.z])

    @property
    def rotation(self) -> NDArray[np.float64]:
        """3x3 of the tool in the base frame: z along the fingers, down but for the tilt; x turned by the yaw."""
        c, s, u, v = math.cos(self.yaw), math.sin(self.yaw), math.cos(self.tilt), math.sin(self.tilt)
        return np.array([[c, s * u, s * v], [s, -c * u, -c * v], [0.0, v, -u]])

    def moved(self, dx: float = 0.0, dy: float = 0.0, dz: float = 0.0) -> DownwardToolPose:
        """The pose shifted in the base frame [m]."""
        return replace(self, x=self.x + dx, y=self.y + dy, z=self.z + dz)


class ArmKinematics:
    """Solves for arm joints on a copy of the state, so that a search never disturbs the simulation."""

    def __init__(self, model: mujoco.MjModel, robot: CellRobot = JACO) -> None:
        self.home = np.array(robot.arm.home)
        self._model = model
        self._data = mujoco.MjData(model)
        self._site = model.site(robot.tool_site).id
        joints = [model.joint(name) for name in robot.arm_joints]
        self._qpos = np.array([j.qposadr[0] for j in joints])
        self._dofs = np.array([j.dofadr[0] for j in joints])
        limited = np.array([bool(model.jnt_limited[j.id]) for j in joints])
        ranges = np.array([model.jnt_range[j.id] for j in joints])
        self._low = np.where(limited, ranges[:, 0], -np.inf)
        self._high = np.where(limited, ranges[:, 1], np.inf)

    def tool_pose(self, joints: NDArray[np.float64]) -> DownwardToolPose:
        """Forward kinematics: pose of the tool for arm joints (J,) [rad]; its yaw is that of its x axis."""
        self._forward(joints)
        x, y, z = self._data.site_xpos[self._site]
        matrix = self._data.site_xmat[self._site]
        yaw, tilt = math.atan2(matrix[3], matrix[0]), math.atan2(matrix[7], -matrix[8])
        return DownwardToolPose(float(x), float(y), float(z), yaw, tilt)

    def solve(self, target: DownwardToolPose, start: NDArray[np.float64], iterations: int = 60) -> NDArray[np.float64]:
        """Arm joints (J,) [rad] that put the tool at ``target``, near ``start``.

        Raises:
            UnreachableError: no solution within 1 mm and 10 mrad.
        """
        joints = np.array(start, dtype=np.float64)
        rotation = target.rotation
        error = np.zeros(6)
        jacobian = np.zeros((6, self._model.nv))
        quaternion = np.zeros(4)
        for _ in range(iterations):
            self._forward(joints)
            error[:3] = target.position - self._data.site_xpos[self._site]
            turn = rotation @ self._data.site_xmat[self._site].reshape(3, 3).T
            mujoco.mju_mat2Quat(quaternion, turn.ravel())
            mujoco.mju_quat2Vel(error[3:], quaternion, 1.0)
            if np.linalg.norm(error[:3]) < 1e-4 and np.linalg.norm(error[3:]) < 1e-3:
                return joints
            mujoco.mj_jacSite(self._model, self._data, jacobian[:3], jacobian[3:], self._site)
            arm = jacobian[:, self._dofs]
            step = _damped_step(arm, error)
            outwards = ((joints <= self._low) & (step < 0)) | ((joints >= self._high) & (step > 0))
            if outwards.any():
                # A joint at its limit cannot help: the others do without it, where there are seven.
                step = _damped_step(np.where(outwards, 0.0, arm), error)
            step *= min(1.0, 0.3 / max(1e-9, float(np.abs(step).max())))
            joints = np.clip(joints + step, self._low, self._high)
        if np.linalg.norm(error[:3]) < 1e-3 and np.linalg.norm(error[3:]) < 1e-2:
            return joints
        raise UnreachableError(
            f"the arm does not reach tool position ({target.x:.3f}, {target.y:.3f}, {target.z:.3f}) m, yaw "
            f"{target.yaw:.2f} rad: {np.linalg.norm(error[:3]):.3f} m short; stay within 0.64 m "
            "of the base and at z 0.01..0.3 m"
        )

    def _forward(self, joints: NDArray[np.float64]) -> None:
        self._data.qpos[self._qpos] = joints
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)


def _damped_step(jacobian: NDArray[np.float64], error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Joint step (J,) [rad] by damped least squares for a Jacobian (6, J) and an error (6,) [m, rad]."""
    step: NDArray[np.float64] = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-4 * np.eye(6), error)
    return step
