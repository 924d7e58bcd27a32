"""Objects moved by somebody else than the robot: pushed along the table, or lifted and set down elsewhere."""

from __future__ import annotations

import mujoco

from mbd_cell.physics.simulation import Pose, Simulation


def put(simulation: Simulation, name: str, pose: Pose) -> None:
    """Set an object down there, at rest, as a hand does that nobody sees.

    Args:
        simulation: of the table.
        name: of the object.
        pose: of the centre of its box [m, robot base frame].

    Raises:
        MbdError: no such object on the table.
    """
    simulation.object_pose(name)
    joint = simulation.model.joint(name)
    place, speed = int(joint.qposadr[0]), int(joint.dofadr[0])
    x, y, z, w = pose.quaternion
    simulation.data.qpos[place : place + 7] = (*pose.position, w, x, y, z)
    simulation.data.qvel[speed : speed + 6] = 0.0
    mujoco.mj_forward(simulation.model, simulation.data)


def push(simulation: Simulation, name: str, velocity: tuple[float, float]) -> None:
    """Give an object a speed (x, y) along the table [m/s], so low that it does not tip; for each tick of the push."""
    speed = int(simulation.model.joint(name).dofadr[0])
    simulation.data.qvel[speed : speed + 6] = (*velocity, 0.0, 0.0, 0.0, 0.0)
