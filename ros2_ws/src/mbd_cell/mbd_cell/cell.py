"""The complete cell without ROS: a laid table, the arm, the hand, and what the teacher is doing, in ticks of 10 ms.

The clock is an integer number of nanoseconds. It stands still while the teacher waits for the wizard, so that how fast
other processes answer never changes the physics: same seed and same commands at the same ticks give the same states and
images.
"""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np
from mbd_model.camera.pose import CameraPose
from mbd_model.objects import Role
from numpy.typing import NDArray

from mbd_cell.arm.hand import GripperCommand, Hand
from mbd_cell.arm.kinematics import ArmKinematics, DownwardToolPose
from mbd_cell.layout.placement import layout
from mbd_cell.layout.scenes import TaskScenes
from mbd_cell.physics.camera import FOVY
from mbd_cell.physics.cell_model import build_model
from mbd_cell.physics.grasp import Grasp
from mbd_cell.physics.robot_model import CellRobot
from mbd_cell.physics.robots import JACO
from mbd_cell.physics.simulation import TICK_NS, Pose, Simulation
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Script, SimulatedArm, Utterance, Word, rest, until_settled
from mbd_cell.teacher.teacher import Teacher

TUCKED = JACO.arm.tucked
START_NS = 1_000_000_000
BESIDE_BASE = 0.1  # [m] a hand nearer to the robot than this is folded away, or turned away from the table
DOWN = -0.9  # cosine of the hand's axis to the vertical from which on it counts as pointing down, if tilted
# Streams of chance that must not disturb one another, nor the layout's.
TEACHING_STREAM, IMAGE_STREAM = 2, 3


class Cell:
    """One task in the cell.

    Attributes:
        time_ns: simulation time [ns].
        waiting_for: the word the teacher waits to be answered; None when time can pass.
        generation: counts the tables laid; a camera belongs to one.
    """

    def __init__(
        self,
        scenes: TaskScenes,
        seed: int,
        camera_pose: CameraPose,
        robot: CellRobot = JACO,
        grasp: Grasp = Grasp.WELD,
    ) -> None:
        self.robot = robot
        self.grasp = grasp
        self.scenes = scenes
        self.seed = seed
        self.role = Role.SOURCE
        self.camera_pose = camera_pose
        self.time_ns = START_NS
        self.waiting_for: Word | None = None
        self.generation = 0
        self._script: Script | None = None
        self._spoken: list[Word] = []
        self._hand = Hand(robot.hand, grasp)
        self._arm_joints: NDArray[np.float64] = np.array(robot.arm.tucked)
        self.lay(Role.SOURCE, seed)

    def lay(self, role: Role, seed: int, scenes: TaskScenes | None = None) -> None:
        """Clear the table and lay that set; the arm stays where it is, holding nothing.

        Raises:
            MbdError: the set does not fit on the table.
        """
        scenes = scenes or self.scenes
        objects = scenes.objects(role)
        model = build_model(objects, layout(scenes, role, seed), self.camera_pose, FOVY, self.robot, grasp=self.grasp)
        self.scenes, self.role, self.seed = scenes, role, seed
        fingers = self._hand.target.copy()
        self._hand.held = None
        self.simulation = Simulation(model, objects, self._arm_joints, fingers, self.robot)
        self.arm = SimulatedArm(ArmKinematics(model, self.robot), self._arm_joints)
        self.stop()
        self.generation += 1

    @property
    def model(self) -> mujoco.MjModel:
        """Of the table as it is laid."""
        return self.simulation.model

    @property
    def busy(self) -> bool:
        """True while the arm or the hand is moving, or the teacher waits."""
        return self._script is not None or not self._hand.settled

    @property
    def following(self) -> bool:
        """True while the arm does what it was commanded, or the teacher guides it."""
        return self._script is not None

    @property
    def hand_settled(self) -> bool:
        """True when the fingers have done what they were commanded."""
        return self._hand.settled

    @property
    def holding(self) -> str | None:
        """Name of the object in the hand: a truth that no robot has."""
        return self._hand.held

    @property
    def fingers_stopped(self) -> bool:
        """True when something keeps the closed hand open: what a hand can tell by its joints."""
        return self._hand.stopped

    @property
    def opening(self) -> float:
        """Of the hand: 0 closed .. 1 open."""
        return self._hand.opening

    def image_rng(self) -> np.random.Generator:
        """Noise of an image taken now: depends on the seed, the set and the time only."""
        return np.random.default_rng([self.seed, IMAGE_STREAM, self.role is Role.TARGET, self.time_ns])

    def tick(self) -> bool:
        """Let 10 ms pass; False (and nothing moves) while the teacher waits for the wizard.

        Raises:
            UnreachableError: the script wants the tool where the arm does not reach; the script has ended.
        """
        if self.waiting_for is not None:
            return False
        if self._script is not None:
            self._advance_script()
            if self.waiting_for is not None:
                return False
        self.simulation.tick(self.arm.target, self._hand.tick(self.simulation))
        self._arm_joints = self.arm.target
        self.time_ns += TICK_NS
        return True

    def catch_up(self, time_ns: int) -> None:
        """Set the clock forward to that time of a session under way, for a cell that came back into it."""
        self.time_ns = max(self.time_ns, time_ns - time_ns % TICK_NS)

    def take_spoken(self) -> list[Word]:
        """The words spoken since the last call."""
        spoken, self._spoken = self._spoken, []
        return spoken

    def gripper(self, command: GripperCommand) -> bool:
        """The wizard's word to the hand. False when the teacher waits for something else; the hand then stays."""
        wanted = None if self.waiting_for is None else ANSWERED_BY_GRIPPER.get(self.waiting_for)
        if self.waiting_for is not None and wanted is not command:
            return False
        self._hand.move(command, self.simulation)
        self.waiting_for = None
        return True

    def begin(self) -> bool:
        """The wizard has started the recording; True when the teacher waited for that."""
        if self.waiting_for is not Word.DEMONSTRATION_BEGINS:
            return False
        self.waiting_for = None
        return True

    def stop(self) -> None:
        """End what is being done; the arm stays where it is."""
        self._script = None
        self.waiting_for = None

    def demonstrate(self) -> None:
        """Let the teacher show the task on the table as it is laid."""
        self.stop()
        rng = np.random.default_rng([self.seed, TEACHING_STREAM])
        teacher = Teacher(self.scenes, self.simulation, self.arm, self._hand, rng)
        self._script = teacher.demonstrate()

    def tuck(self) -> None:
        """Open the hand and fold the arm back."""
        self.stop()
        self._script = self._tuck()

    def move_tool(self, goal: DownwardToolPose, speed: float) -> None:
        """Move the tool straight there, a folded arm by way of home; raises UnreachableError when out of reach."""
        self.stop()
        tool = self.simulation.tool
        folded = not points_down(tool) or tool.position[0] < BESIDE_BASE
        self.arm.kinematics.solve(goal, self.arm.kinematics.home if folded else self.arm.target, iterations=400)
        self._script = self._move(goal, speed, folded)

    def follow(self, way: Iterator[NDArray[np.float64]]) -> None:
        """Take these joint targets (J,) [rad], one a tick."""
        self.stop()
        self._script = self._through(way)

    def move_gripper(self, command: GripperCommand) -> None:
        """Open or close the hand."""
        self.stop()
        self._hand.move(command, self.simulation)
        self._script = until_settled(self._hand)

    def _through(self, way: Iterator[NDArray[np.float64]]) -> Script:
        for joints in way:
            self.arm.take(joints)
            yield None

    def _move(self, goal: DownwardToolPose, speed: float, folded: bool) -> Script:
        if folded:
            # Between a folded arm and a hand that points down there is no straight way for the tool.
            yield from self.arm.swing(self.arm.kinematics.home, 2.0)
        yield from self.arm.guide(goal, speed, 0.0, np.random.default_rng(0))

    def _tuck(self) -> Script:
        if self._hand.command is GripperCommand.CLOSE:
            self._hand.move(GripperCommand.OPEN, self.simulation)
            yield from until_settled(self._hand)
        yield from self.arm.swing(np.array(self.robot.arm.tucked), 2.5)
        yield from rest(0.3)

    def _advance_script(self) -> None:
        if self._script is None:
            return
        try:
            item = next(self._script)
            while isinstance(item, Utterance):
                self._spoken.append(item.word)
                if item.waits:
                    self.waiting_for = item.word
                    return
                item = next(self._script)
        except StopIteration:
            self._script = None
        except ValueError:
            self._script = None
            raise


def points_down(tool: Pose) -> bool:
    """Whether the hand's axis points down."""
    x, y, _, _ = tool.quaternion
    return 1.0 - 2.0 * (x * x + y * y) < DOWN
