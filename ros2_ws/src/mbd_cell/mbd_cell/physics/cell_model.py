"""The cell as a MuJoCo model: a robot, table, camera, and the objects on the table.

World = robot base frame: x away from the robot, y to its left, z up; the table top is z = 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
from mbd_model.camera.pose import CameraPose

from mbd_cell.layout.placement import Placement
from mbd_cell.layout.scenes import ObjectSpec
from mbd_cell.layout.shapes import add_object
from mbd_cell.physics.camera_pose import mujoco_quaternion
from mbd_cell.physics.grasp import CONTACTS, ContactSettings, Grasp
from mbd_cell.physics.robot_model import CellRobot
from mbd_cell.physics.robots import JACO

TABLE_TOP = (0.50, 0.0, 0.36, 0.60)  # centre x, y and half size x, y [m]
CAMERA = "camera"
MEMORY = 2**27  # [bytes]
WIDTH, HEIGHT = 640, 480


def build_model(
    objects: Sequence[ObjectSpec],
    placements: Sequence[Placement],
    camera: CameraPose,
    fovy: float,
    robot: CellRobot = JACO,
    *,
    grasp: Grasp = Grasp.WELD,
) -> mujoco.MjModel:
    """Compile the cell with these objects standing on the table.

    Args:
        objects: the set to lay.
        placements: where, in the same order.
        camera: pose of the optical frame in the base frame.
        fovy: vertical field of view [deg].
        robot: arm and hand.
        grasp: what keeps things in the hand.
    """
    contacts = CONTACTS[grasp]
    spec = mujoco.MjSpec()
    # Nested cups of boxes touch in hundreds of points; what MuJoCo sets aside by itself is too little for them.
    spec.memory = MEMORY
    spec.option.timestep = contacts.timestep
    spec.option.noslip_iterations = contacts.noslip_iterations
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = contacts.impratio
    spec.stat.extent = 1.0
    spec.stat.center = (0.4, 0.0, 0.2)
    _set_visuals(spec)
    _add_furniture(spec, contacts)
    robot.add_to(spec, grasp, contacts)
    camera_body = spec.worldbody.add_body(name="camera_mount", pos=camera.position, quat=mujoco_quaternion(camera))
    camera_body.add_camera(name=CAMERA, fovy=fovy)
    for thing, place in zip(objects, placements, strict=True):
        add_object(spec, thing, (place.x, place.y, thing.size[2] / 2), place.yaw, contacts.object_friction)
        spec.add_equality(
            name=weld_name(thing.name), type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=robot.hand_body, name2=thing.name, active=False, solref=(0.01, 1.0),
        )  # fmt: skip
    return spec.compile()


def weld_name(object_name: str) -> str:
    """Name of the constraint that a grasp of that object activates."""
    return f"grasp_{object_name}"


def _set_visuals(spec: mujoco.MjSpec) -> None:
    spec.visual.map.znear = 0.05
    spec.visual.map.zfar = 4.0
    spec.visual.quality.offsamples = 0
    spec.visual.quality.shadowsize = 0
    spec.visual.headlight.ambient = (0.4, 0.4, 0.4)
    spec.visual.headlight.diffuse = (0.25, 0.25, 0.25)
    spec.visual.headlight.specular = (0.0, 0.0, 0.0)
    spec.visual.global_.offwidth = WIDTH
    spec.visual.global_.offheight = HEIGHT
    spec.worldbody.add_light(
        pos=(0.2, 0.5, 1.8), dir=(0.15, -0.3, -1.0), type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        diffuse=(0.5, 0.5, 0.5), specular=(0.0, 0.0, 0.0), castshadow=False,
    )  # fmt: skip


def _add_furniture(spec: mujoco.MjSpec, contacts: ContactSettings) -> None:
    x, y, half_x, half_y = TABLE_TOP
    spec.worldbody.add_geom(
        name="table", type=mujoco.mjtGeom.mjGEOM_BOX, pos=(x, y, -0.02), size=(half_x, half_y, 0.02),
        rgba=(0.72, 0.72, 0.72, 1.0), friction=contacts.object_friction, contype=1, conaffinity=1,
    )  # fmt: skip
    spec.worldbody.add_geom(
        name="pedestal", type=mujoco.mjtGeom.mjGEOM_BOX, pos=(0.0, 0.0, -0.38), size=(0.1, 0.12, 0.38),
        rgba=(0.25, 0.25, 0.25, 1.0), contype=0, conaffinity=0,
    )  # fmt: skip
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, pos=(0.0, 0.0, -0.76), size=(3.0, 3.0, 0.1),
        rgba=(0.35, 0.35, 0.35, 1.0), contype=1, conaffinity=1,
    )  # fmt: skip
