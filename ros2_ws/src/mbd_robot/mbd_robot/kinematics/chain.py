"""The arm as a chain of joints with the suite's tool at its end and what it holds, beside a table and boxes."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mbd_robot.geometry import HeldBoxes, Obstacle, RobotToolPose
from mbd_robot.kinematics.descriptions import ModelError, load_description
from mbd_robot.profiles.robot import RobotProfile

TOOL = "suite_tool"
BOXES, HELD = 32, 6  # that can be taken into account at once, on the table and in the hand
PALM_RADIUS, PALM_END = 0.04, 0.09  # [m] of what stands for the hand: how thick, and how far above the tool it ends
LINK_RADIUS = 0.04  # [m] of links whose description has no shape
FAR = 1e3  # [m] where boxes are that are not there


class ArmChain:
    """Kinematics of one robot, and its distances to what stands around.

    Args:
        profile: of the robot.
        description: URDF or MJCF text, where a topic gave it.
        table_height: [m] of the table's top; None: no table.

    Raises:
        ModelError: the description lacks a joint or the tip that the profile names.
    """

    def __init__(self, profile: RobotProfile, description: str = "", table_height: float | None = 0.0) -> None:
        self.profile = profile
        spec = load_description(profile.arm.model, description)
        _add_tool(spec, profile)
        _add_surroundings(spec, table_height)
        try:
            self.model: mujoco.MjModel = spec.compile()
        except ValueError as error:
            raise ModelError(f"the description of '{profile.title}' cannot be used: {error}") from error
        self.data = mujoco.MjData(self.model)
        names = [self.model.joint(i).name for i in range(self.model.njnt)]
        missing = [n for n in profile.arm.joints if n not in names]
        if missing:
            raise ModelError(f"the description has no joint {', '.join(missing)}; it has {', '.join(names)}")
        joints = [self.model.joint(n) for n in profile.arm.joints]
        self.qpos = np.array([j.qposadr[0] for j in joints])
        self.dofs = np.array([j.dofadr[0] for j in joints])
        limited = np.array([bool(self.model.jnt_limited[j.id]) for j in joints])
        ranges = np.array([self.model.jnt_range[j.id] for j in joints])
        self.low = np.where(limited, ranges[:, 0], -np.inf)
        self.high = np.where(limited, ranges[:, 1], np.inf)
        self._site = self.model.site(TOOL).id
        self.links = self._link_geoms()
        # Else they would stay where the tip is: MuJoCo takes over what coincided when the model was made.
        self.model.geom_sameframe[[self.model.geom(f"held_{i}").id for i in range(HELD)]] = 0
        self._obstacles: tuple[Obstacle, ...] = ()
        self._held: tuple[int, ...] = ()

    def at(self, joints: NDArray[np.float64]) -> None:
        """Take these joint angles (J,) [rad]."""
        self.data.qpos[self.qpos] = joints
        mujoco.mj_kinematics(self.model, self.data)

    def tool_pose(self, joints: NDArray[np.float64]) -> RobotToolPose:
        """Forward kinematics for joint angles (J,) [rad]."""
        self.at(joints)
        rotation = Rotation.from_matrix(self.data.site_xmat[self._site].reshape(3, 3))
        return RobotToolPose(np.array(self.data.site_xpos[self._site]), rotation.as_quat())

    def surround(self, obstacles: Sequence[Obstacle]) -> None:
        """Keep clear of these boxes; the first ``BOXES`` of them count."""
        self._obstacles = tuple(obstacles[:BOXES])
        for i in range(BOXES):
            geom, body = self.model.geom(f"box_{i}").id, self.model.body(f"box_{i}").mocapid[0]
            if i >= len(self._obstacles):
                self.data.mocap_pos[body] = (0.0, 0.0, -FAR)
                continue
            box = self._obstacles[i]
            self.model.geom_size[geom] = np.array(box.size) / 2
            self.model.geom_rbound[geom] = float(np.linalg.norm(box.size)) / 2
            self.data.mocap_pos[body] = box.centre
            x, y, z, w = Rotation.from_euler("z", box.yaw).as_quat()
            self.data.mocap_quat[body] = (w, x, y, z)

    def hold(self, held: HeldBoxes) -> None:
        """Take these boxes along with the tool; the first ``HELD`` of them count."""
        self._held = ()
        if held.grasp is None:
            return
        boxes, turn = held.boxes[:HELD], held.grasp.rotation.inv()
        self._held = tuple(self.model.geom(f"held_{i}").id for i in range(len(boxes)))
        for geom, box in zip(self._held, boxes, strict=True):
            self.model.geom_size[geom] = np.array(box.size) / 2
            self.model.geom_rbound[geom] = float(np.linalg.norm(box.size)) / 2
            # In the tool's frame, and with it in the frame of the tip.
            place = turn.apply(np.subtract(box.centre, held.grasp.position))
            site = Rotation.from_quat(np.roll(self.model.site_quat[self._site], -1))
            self.model.geom_pos[geom] = self.model.site_pos[self._site] + site.apply(place)
            self.model.geom_quat[geom] = np.roll((site * turn * Rotation.from_euler("z", box.yaw)).as_quat(), 1)

    def nearest(self, joints: NDArray[np.float64]) -> tuple[float, str]:
        """How near the arm comes to table and boxes [m], negative inside, and what it is near to ("" for nothing).

        The fingers count for nothing: they are to reach between the objects, and down to the table. What is held
        counts for nothing either: it is to come down onto others (see ``held_nearest``).
        """
        self.at(joints)
        return self._nearest(self.links, self._things())

    def held_nearest(self, joints: NDArray[np.float64], but: Collection[str] = ()) -> tuple[float, str]:
        """How near what is held comes to table and boxes [m], but for those named, and what it is near to."""
        if not self._held:
            return FAR, ""
        self.at(joints)
        return self._nearest(self._held, [(geom, called) for geom, called in self._things() if called not in but])

    def touched_by_held(self, joints: NDArray[np.float64], within: float) -> frozenset[str]:
        """Names of all to which what is held is nearer than that [m]."""
        self.at(joints)
        return frozenset(name for geom, name in self._things() if self._nearest(self._held, [(geom, name)])[0] < within)

    def _things(self) -> list[tuple[int, str]]:
        """Geoms of what stands around, and their names."""
        things = [(self.model.geom(f"box_{i}").id, o.name) for i, o in enumerate(self._obstacles)]
        if (table := mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_GEOM, "table")) >= 0:
            things.append((table, "the table"))
        return things

    def _nearest(self, own: Sequence[int], things: Sequence[tuple[int, str]]) -> tuple[float, str]:
        best, name = FAR, ""
        for other, called in things:
            for link in own:
                distance = mujoco.mj_geomDistance(self.model, self.data, link, other, min(best, 0.5), None)
                if distance < best:
                    best, name = float(distance), called
        return best, name

    def _link_geoms(self) -> list[int]:
        """Geoms of what moves with the arm."""
        moving = {int(self.model.jnt_bodyid[self.model.joint(self.profile.arm.joints[0]).id])}
        for body in range(self.model.nbody):
            if int(self.model.body_parentid[body]) in moving:
                moving.add(body)
        held = {self.model.geom(f"held_{i}").id for i in range(HELD)}
        return [g for g in range(self.model.ngeom) if int(self.model.geom_bodyid[g]) in moving and g not in held]


def _add_tool(spec: mujoco.MjSpec, profile: RobotProfile) -> None:
    """The suite's tool point, the palm above it, and shapes for links that have none."""
    tip = spec.body(profile.arm.tip)
    if tip is None:
        names = ", ".join(b.name for b in spec.bodies if b.name)
        raise ModelError(f"the description has no link '{profile.arm.tip}'; it has {names}")
    for body in spec.bodies:
        if not body.geoms and body.joints:
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(LINK_RADIUS, 0.0, 0.0), mass=0.1)
        if not body.geoms and body.parent is not None and body.mass <= 0.0:
            body.mass, body.inertia, body.explicitinertial = 0.001, (1e-6, 1e-6, 1e-6), True
    x, y, z, w = Rotation.from_euler("z", profile.tool_pose.turn).as_quat()
    tip.add_site(name=TOOL, pos=profile.tool_pose.offset, quat=(w, x, y, z))
    end = np.array(profile.tool_pose.offset) - (0.0, 0.0, PALM_END)
    tip.add_geom(
        name="palm", type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=(PALM_RADIUS, 0.0, 0.0), mass=0.1,
        fromto=np.concatenate(((0.0, 0.0, min(-0.02, end[2] - 0.02)), end)),
    )  # fmt: skip
    for i in range(HELD):
        tip.add_geom(name=f"held_{i}", type=mujoco.mjtGeom.mjGEOM_BOX, size=(0.001, 0.001, 0.001), mass=0.0)


def _add_surroundings(spec: mujoco.MjSpec, table_height: float | None) -> None:
    if table_height is not None:
        spec.worldbody.add_geom(
            name="table", type=mujoco.mjtGeom.mjGEOM_BOX, pos=(0.75, 0.0, table_height - 0.5), size=(0.6, 1.0, 0.5)
        )
    for i in range(BOXES):
        box = spec.worldbody.add_body(name=f"box_{i}", mocap=True, pos=(0.0, 0.0, -FAR))
        box.add_geom(name=f"box_{i}", type=mujoco.mjtGeom.mjGEOM_BOX, size=(0.01, 0.01, 0.01))
