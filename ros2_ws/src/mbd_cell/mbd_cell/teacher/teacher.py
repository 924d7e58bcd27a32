"""The scripted teacher: guides the arm by hand through the demonstrated steps and states when to close and open."""

from __future__ import annotations

import numpy as np
from mbd_model.task import StepKind

from mbd_cell.arm.grasp_planning import ROUND, grasp_pose, rest_height, yaw_of
from mbd_cell.arm.hand import Hand
from mbd_cell.arm.kinematics import DownwardToolPose
from mbd_cell.arm.motion import angle_between
from mbd_cell.layout.scenes import DemonstratedStep, TaskScenes
from mbd_cell.physics.simulation import Simulation
from mbd_cell.teacher.script import Script, SimulatedArm, Utterance, Word, rest, until_settled

SPEED = 0.22  # of the hand-guided tool [m/s]
APPROACH_SPEED = 0.12
TREMBLE = 0.004  # [m]
CLEARANCE = 0.05  # between what the hand carries and what it passes over [m]
HOVER = 0.07  # above a grasp or release before going straight down [m]
MAX_TOOL_HEIGHT = 0.40


class Teacher:
    """Shows one task on one laid table."""

    def __init__(
        self, scenes: TaskScenes, simulation: Simulation, arm: SimulatedArm, hand: Hand, rng: np.random.Generator
    ) -> None:
        self._scenes = scenes
        self._simulation = simulation
        self._arm = arm
        self._hand = hand
        self._rng = rng
        self._objects = {o.name: o for o in scenes.source}
        self._grip = 0.0  # tool height above the held object's bottom [m]

    def demonstrate(self) -> Script:
        """The complete demonstration, from the first word to the last."""
        yield Utterance(Word.DEMONSTRATION_BEGINS)
        yield from rest(0.5)
        yield from self._arm.swing(self._arm.kinematics.home, 2.0)
        for step in self._scenes.steps:
            if step.kind is StepKind.PICK:
                yield from self._pick(step)
            else:
                yield from self._place(step)
        yield from rest(0.5)
        yield Utterance(Word.DEMONSTRATION_ENDS)

    def _pick(self, step: DemonstratedStep) -> Script:
        thing = self._objects[step.picked]
        pose = self._simulation.object_pose(step.picked)
        grasp = grasp_pose(thing, pose, near_yaw=self._arm.pose.yaw if abs(self._arm.pose.yaw) < 1.6 else 0.0)
        self._grip = grasp.z - (pose.position[2] - thing.size[2] / 2)
        yield from self._over(grasp, self._highest_top() + CLEARANCE)
        yield from self._guide(grasp, APPROACH_SPEED)
        yield from rest(0.3)
        yield Utterance(Word.CLOSE)
        yield from until_settled(self._hand)
        yield from rest(0.3)

    def _place(self, step: DemonstratedStep) -> Script:
        release = self._release_pose(step)
        over = self._highest_top(but=step.picked) + self._grip + CLEARANCE
        yield from self._over(release, over)
        yield from self._guide(release, APPROACH_SPEED)
        yield from rest(0.3)
        yield Utterance(Word.OPEN)
        yield from until_settled(self._hand)
        yield from rest(0.4)
        yield from self._guide(release.moved(dz=HOVER), APPROACH_SPEED)

    def _release_pose(self, step: DemonstratedStep) -> DownwardToolPose:
        held = self._objects[step.picked]
        now = self._simulation.object_pose(step.picked)
        tool = self._arm.pose
        dx, dy = step.position
        onto = self._objects[step.onto] if step.onto is not None else None
        onto_pose = self._simulation.object_pose(step.onto) if step.onto is not None else None
        if onto_pose is None:
            x, y, base_yaw = dx, dy, 0.0
        else:
            base_yaw = yaw_of(onto_pose)
            c, s = np.cos(base_yaw), np.sin(base_yaw)
            x, y = onto_pose.position[0] + c * dx - s * dy, onto_pose.position[1] + s * dx + c * dy
        turn = 0.0
        if step.turn is not None:
            # Of a round thing the hand's own turn matters: its fingers need room where it is released.
            yaw = tool.yaw if held.shape in ROUND else yaw_of(now)
            # Things look the same after half a turn, so the hand takes the shorter way.
            turns = [angle_between(yaw, base_yaw + step.turn + k * np.pi) for k in (0, 1)]
            turn = min(turns, key=lambda angle: abs(tool.yaw + angle))
        # The object does not hang exactly below the tool; what must arrive above (x, y) is the object.
        c, s = np.cos(turn), np.sin(turn)
        hang_x, hang_y = now.position[0] - tool.x, now.position[1] - tool.y
        bottom = rest_height(held, self._grip, onto, onto_pose)
        return DownwardToolPose(
            float(x - (c * hang_x - s * hang_y)), float(y - (s * hang_x + c * hang_y)), bottom + self._grip,
            tool.yaw + turn,
        )  # fmt: skip

    def _highest_top(self, but: str = "") -> float:
        """Top of the highest thing on the table [m]."""
        return max(
            self._simulation.object_pose(name).position[2] + thing.size[2] / 2
            for name, thing in self._objects.items()
            if name != but
        )

    def _over(self, goal: DownwardToolPose, height: float) -> Script:
        """Up, across and to a place above the goal, at least at ``height``."""
        now = self._arm.pose
        height = min(MAX_TOOL_HEIGHT, max(height, goal.z + HOVER))
        if now.z < height - 0.01:
            yield from self._guide(DownwardToolPose(now.x, now.y, height, now.yaw), SPEED)
        yield from self._guide(DownwardToolPose(goal.x, goal.y, height, goal.yaw), SPEED)
        if height > goal.z + HOVER + 0.01:
            yield from self._guide(goal.moved(dz=HOVER), SPEED)

    def _guide(self, end: DownwardToolPose, speed: float) -> Script:
        yield from self._arm.guide(end, speed, TREMBLE, self._rng)
