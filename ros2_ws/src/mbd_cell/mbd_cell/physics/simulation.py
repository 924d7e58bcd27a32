"""The cell in motion: one physics state with the arm's and hand's targets, stepped in control ticks of 10 ms.

Deterministic: the same model, start and targets at the same ticks give bit-equal states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_cell.layout.scenes import ObjectSpec
from mbd_cell.physics.cell_model import weld_name
from mbd_cell.physics.robot_model import CellRobot
from mbd_cell.physics.robots import JACO

TICK_NS = 10_000_000
# A finger holds something when it presses on it with this at least [N].
PRESSED = 0.2


@dataclass(frozen=True)
class Pose:
    """Position (x, y, z) [m] and quaternion (x, y, z, w) in the robot base frame."""

    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


class Simulation:
    """Physics of one laid table."""

    def __init__(
        self,
        model: mujoco.MjModel,
        objects: Sequence[ObjectSpec],
        arm: NDArray[np.float64],
        fingers: NDArray[np.float64],
        robot: CellRobot = JACO,
    ) -> None:
        """Start at rest.

        Args:
            model: from ``cell_model.build_model``.
            objects: what it has on the table.
            arm: (J,) joint angles [rad].
            fingers: (F,) positions of the hand's joints [rad or m].
            robot: that the model was built with.
        """
        self.model = model
        self.robot = robot
        self.data = mujoco.MjData(model)
        self.objects = {o.name: o for o in objects}
        self._steps_per_tick = round(1e-9 * TICK_NS / model.opt.timestep)
        self._arm = np.array([model.joint(n).qposadr[0] for n in robot.arm_joints])
        self._arm_dofs = np.array([model.joint(n).dofadr[0] for n in robot.arm_joints])
        self._fingers = np.array([model.joint(n).qposadr[0] for n in robot.hand_joints])
        self._finger_dofs = np.array([model.joint(n).dofadr[0] for n in robot.hand_joints])
        self._arm_controls = np.array([model.actuator(n).id for n in robot.arm_joints])
        self._finger_controls = np.array([model.actuator(n).id for n in robot.hand_joints])
        self._hand = model.body(robot.hand_body).id
        self._body_of_object = {name: model.body(name).id for name in self.objects}
        self._finger_of_body = {
            model.body(body).id: finger for finger, bodies in enumerate(robot.finger_bodies, start=1) for body in bodies
        }
        self.data.qpos[self._arm] = arm
        self.data.qpos[self._fingers] = fingers
        self.data.ctrl[self._arm_controls] = arm
        self.data.ctrl[self._finger_controls] = fingers
        mujoco.mj_forward(model, self.data)

    def tick(self, arm_target: NDArray[np.float64], finger_target: NDArray[np.float64]) -> None:
        """Advance 10 ms with these joint targets (J,), (F,) [rad or m]."""
        self.data.ctrl[self._arm_controls] = arm_target
        self.data.ctrl[self._finger_controls] = finger_target
        mujoco.mj_step(self.model, self.data, nstep=self._steps_per_tick)

    @property
    def arm_joints(self) -> NDArray[np.float64]:
        """(J,) [rad]."""
        return np.array(self.data.qpos[self._arm])

    @property
    def finger_joints(self) -> NDArray[np.float64]:
        """(F,) [rad or m], larger = more closed."""
        return np.array(self.data.qpos[self._fingers])

    @property
    def joint_speeds(self) -> NDArray[np.float64]:
        """(J + F,) arm then fingers [rad/s or m/s]."""
        return np.array(self.data.qvel[np.concatenate((self._arm_dofs, self._finger_dofs))])

    @property
    def tool(self) -> Pose:
        """Where the tool is."""
        site = self.model.site(self.robot.tool_site).id
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, self.data.site_xmat[site])
        return _pose(self.data.site_xpos[site], quaternion)

    def object_pose(self, name: str) -> Pose:
        """Where the centre of that object's bounding box is.

        Raises:
            MbdError: no such object on the table; lists those there are.
        """
        if name not in self._body_of_object:
            raise MbdError(f"no object '{name}' on the table; there are {sorted(self._body_of_object)}")
        body = self._body_of_object[name]
        return _pose(self.data.xpos[body], self.data.xquat[body])

    def touching_fingers(self) -> dict[str, set[int]]:
        """For each object that fingers touch, which (from 1 on)."""
        return {name: set(forces) for name, forces in self.finger_forces().items()}

    def finger_forces(self) -> dict[str, dict[int, float]]:
        """For each object that fingers touch, how hard each finger (from 1 on) presses on it [N]."""
        names = {body: name for name, body in self._body_of_object.items()}
        pressing: dict[str, dict[int, float]] = {}
        force = np.zeros(6)
        for index, contact in enumerate(self.data.contact[: self.data.ncon]):
            bodies = [int(self.model.geom_bodyid[g]) for g in contact.geom]
            for one, other in (bodies, bodies[::-1]):
                if one in names and other in self._finger_of_body:
                    mujoco.mj_contactForce(self.model, self.data, index, force)
                    fingers, finger = pressing.setdefault(names[one], {}), self._finger_of_body[other]
                    fingers[finger] = fingers.get(finger, 0.0) + float(force[0])
        return pressing

    def pressed(self) -> str | None:
        """The object that finger 1 and one opposite it press between them; of several the one pressed hardest."""
        grips = {
            name: min(forces.get(1, 0.0), max((f for finger, f in forces.items() if finger != 1), default=0.0))
            for name, forces in sorted(self.finger_forces().items())
        }
        best = max(grips, key=lambda name: grips[name], default=None)
        return best if best is not None and grips[best] >= PRESSED else None

    def hold(self, name: str) -> None:
        """Weld the object to the hand as it now lies in it."""
        equality = self.model.equality(weld_name(name)).id
        body = self._body_of_object[name]
        inverse, relative = np.zeros(4), np.zeros(4)
        mujoco.mju_negQuat(inverse, self.data.xquat[self._hand])
        mujoco.mju_mulQuat(relative, inverse, self.data.xquat[body])
        offset = np.zeros(3)
        mujoco.mju_rotVecQuat(offset, self.data.xpos[body] - self.data.xpos[self._hand], inverse)
        # Weld data: anchor in the object, object's position and quaternion in the hand, torque scale.
        self.model.eq_data[equality, :11] = np.concatenate((np.zeros(3), offset, relative, [1.0]))
        self.data.eq_active[equality] = 1

    def let_go(self, name: str) -> None:
        """End the weld of that object."""
        self.data.eq_active[self.model.equality(weld_name(name)).id] = 0


def _pose(position: NDArray[np.float64], wxyz: NDArray[np.float64]) -> Pose:
    x, y, z = (float(v) for v in position)
    w, i, j, k = (float(v) for v in wxyz)
    return Pose((x, y, z), (i, j, k, w))
