"""The cell node: steps the simulated cell, publishes what a real one would, and obeys wizard and session."""

from __future__ import annotations

import time
from typing import Any

import rclpy
from mbd_model.errors import MbdError
from mbd_model.ros.conversions import role_from_code, stamp_from_msg
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.ros.run_node import run_node
from mbd_model.ros.spinning import spin_for
from mbd_model.session import Phase
from mbd_model.times import to_seconds
from mbd_msgs.msg import (
    CellTruth,
    SessionState,
    Speech,
    WizardCommand,
    WizardDemonstration,
    WizardReply,
)
from mbd_msgs.srv import LayTable
from rclpy.executors import Executor

from mbd_cell.cell import Cell
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.parameters import CELL
from mbd_cell.physics.camera import Camera
from mbd_cell.ros import conversions as convert
from mbd_cell.ros.own_driver import OwnCamera, OwnRobot
from mbd_cell.ros.parameters import cell_parameters
from mbd_cell.ros.stand_in.camera import StandInCamera
from mbd_cell.ros.stand_in.pace import Pace
from mbd_cell.ros.stand_in.robot import StandInRobot
from mbd_cell.ros.stated_time import StatedTime
from mbd_cell.stage import Stage
from mbd_cell.teacher.reminder import Reminder
from mbd_cell.teacher.script import Word

TICKS_PER_SLICE = 3  # 30 ms of simulated time between two poses of the robot
# While the robot works and nobody watches: nothing is read off its path then, and each pose goes to a dozen processes.
TICKS_AT_WORK = 6
# With nothing moving, time runs no faster than the wall clock: the processor belongs to those who look.
IDLE_SPEED = 1.0
LONGEST_SESSION_NS = 10**6 * 10**9
BREATH = 0.002  # [s] for those who listen
MAX_LAG = 0.5  # [s] behind the wall clock after which a slow machine is not caught up with


class CellNode(TableNode):
    """Publishes camera, robot, clock, truth and speech of one simulated cell."""

    def __init__(self, **options: Any) -> None:
        super().__init__(CELL, **options)
        self._settings = cell_parameters(self.values)
        scenes = load_scenes(self._settings.scene_file(self._settings.task))
        settings = self._settings
        self.cell = Cell(scenes, settings.seed, settings.camera, settings.cell_robot, settings.grasp)
        self.stage = Stage(self.cell, self._settings.teacher)
        profile, camera = self._settings.robot, self._settings.camera_driver
        self._frame = profile.base_frame if profile else convert.BASE_FRAME
        self._robot: OwnRobot | StandInRobot = (
            StandInRobot(self, self.stage, profile) if profile else OwnRobot(self, self.stage, self._settings.driver)
        )
        self._images = StandInCamera(self, camera) if camera else OwnCamera(self)
        self._pace = Pace(self) if profile else None
        self._begun_stiff = False
        self._camera: Camera | None = None
        self._table_seen = -1
        self._next_image = 0
        self._due = time.monotonic()
        self._reminder = Reminder(self._settings.reminder)
        self._asked_to_begin = False
        self._redo = False
        self._time = StatedTime(self)
        self._truth = self.create_publisher(CellTruth, "cell/truth", LATCHED)
        self._speech = self.create_publisher(Speech, "cell/speech", EVENTS)
        self.create_subscription(WizardDemonstration, "wizard/demonstration", self._on_demonstration, EVENTS)
        self.create_subscription(WizardCommand, "wizard/command", self._on_command, EVENTS)
        self.create_subscription(WizardReply, "interaction/replies", self._on_reply, EVENTS)
        self.create_subscription(SessionState, "interaction/state", self._on_state, LATCHED)
        self.create_service(LayTable, "cell/lay_table", self._on_lay_table)
        self.get_logger().info(
            f"{scenes.task}, seed {self.cell.seed}: the source set is on the table; grasps hold by {settings.grasp}"
        )

    def close(self) -> None:
        """Free the GL context."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def advance(self) -> float:
        """Let a slice of simulated time pass and publish it; returns how long to wait before the next [s]."""
        before = self.cell.time_ns
        if self._pace is not None and self._pace.ahead(before):
            self._time.state(before, time.monotonic())
            return BREATH
        for _ in range(self._ticks()):
            try:
                passed = self.stage.tick()
            except MbdError as error:
                self.get_logger().error(f"the motion ended: {error}")
                passed = True
            words = self.stage.take_words()
            if words or not passed:
                break
        self._time.state(self.cell.time_ns, time.monotonic())
        if self.cell.time_ns != before:
            self._robot.publish()
        if self._robot.update():
            self._publish_truth()
        if self._begun_stiff and self._robot.soft:
            self._begun_stiff = not self.stage.begin()
        if self.cell.generation != self._table_seen:
            self._show_new_table()
        if self.cell.time_ns >= self._next_image:
            self._publish_image()
        for word in words:
            self._speak(word)
            if word is Word.DEMONSTRATION_ENDS:
                self._publish_truth()
        self._remind()
        return self._wait(self.cell.time_ns - before)

    def _ticks(self) -> int:
        fast = self._settings.speed == 0.0 and self.stage.phase is Phase.EXECUTE
        return TICKS_AT_WORK if fast else TICKS_PER_SLICE

    def _wait(self, passed_ns: int) -> float:
        if passed_ns == 0:
            return 0.02
        speed = self._settings.speed
        if not self.cell.busy:
            speed = min(speed, IDLE_SPEED) if speed > 0 else IDLE_SPEED
        now = time.monotonic()
        if speed == 0.0:
            self._due = now
            return 0.0
        self._due = max(self._due + to_seconds(passed_ns) / speed, now - MAX_LAG)
        return max(0.0, self._due - now)

    def _publish_truth(self) -> None:
        self._truth.publish(convert.truth_to_msg(self.cell, self._frame))

    def _show_new_table(self) -> None:
        self.close()
        self._camera = Camera(self.cell.model)
        self._table_seen = self.cell.generation
        self._next_image = self.cell.time_ns
        self._publish_truth()

    def _publish_image(self) -> None:
        moving = self.cell.busy
        rate = self._settings.camera_rate_moving if moving else self._settings.camera_rate
        self._next_image = self.cell.time_ns + round(1e9 / rate)
        if self._camera is None or not self._images.watched():
            return
        stamp = self.cell.time_ns
        frame = self._camera.render(self.cell.simulation, self.cell.image_rng() if self._settings.noise else None)
        self._images.publish(frame, stamp)

    def _speak(self, word: Word) -> None:
        self._reminder.said(time.monotonic())
        self._say(word)

    def _say(self, word: Word) -> None:
        self._speech.publish(convert.speech_to_msg(word, self.cell.time_ns))
        self.get_logger().info(f"teacher: {word.name}")

    def _remind(self) -> None:
        word = self.stage.unanswered
        if word is None or not self._reminder.due(time.monotonic()):
            return
        if self._reminder.repeated == 1:  # once: an operator who takes his time does nothing wrong
            still = " (the simulation's clock stands still)" if self.cell.waiting_for else ""
            self.get_logger().info(f"nobody acted on {word.name} yet{still}; the teacher says it again now and then")
        self._say(word)

    def _on_demonstration(self, msg: WizardDemonstration) -> None:
        if msg.command == WizardDemonstration.STOP:
            self.stage.acknowledge(Word.DEMONSTRATION_ENDS)
        elif self.count_publishers(self.resolve_topic_name("interaction/replies")):
            # The recording has begun only when the dialogue reports it.
            self._asked_to_begin = True
        else:
            self._begin()

    def _begin(self) -> None:
        """The demonstration is being recorded; a teacher cannot guide an arm that is stiff."""
        if self._robot.soft:
            self.stage.begin()
            return
        self._begun_stiff = True
        self.get_logger().warning("the arm is stiff: the teacher waits until hand guiding is on")

    def _on_command(self, msg: WizardCommand) -> None:
        self._redo = msg.command == WizardCommand.REDO
        self.stage.acknowledge(Word.READY)

    def _on_reply(self, msg: WizardReply) -> None:
        if msg.topic.endswith("wizard/demonstration") and self._asked_to_begin:
            self._asked_to_begin = False
            if msg.accepted:
                self._begin()
        if msg.topic.endswith("wizard/command") and self._redo:
            self._redo = False
            if msg.accepted and self.stage.phase is not None:
                self.stage.enter(self.stage.phase, again=True)

    def _on_state(self, msg: SessionState) -> None:
        stamp = stamp_from_msg(msg.header.stamp)
        # A cell that was started again must not turn the session's time back; a stamp of the wall clock is none of its.
        if self.stage.phase is None and stamp < LONGEST_SESSION_NS:
            self.cell.catch_up(stamp)
        try:
            self.stage.enter(Phase(msg.phase))
        except ValueError as error:
            self.get_logger().error(f"interaction/state: {error}")

    def _on_lay_table(self, request: LayTable.Request, response: LayTable.Response) -> LayTable.Response:
        try:
            scenes = load_scenes(self._settings.scene_file(request.task)) if request.task else None
            self.cell.lay(role_from_code(request.role), request.seed, scenes)
        except MbdError as error:
            response.success, response.message = False, str(error)
            return response
        self.stage.laid_again()
        response.success = True
        response.message = f"{self.cell.scenes.task}: the {self.cell.role} set, seed {self.cell.seed}"
        return response


def spin(executor: Executor, node: CellNode) -> None:
    """Let simulated time pass, and take what arrives between its slices."""
    try:
        while rclpy.ok():
            # What arrives meanwhile is taken before time passes again.
            spin_for(executor, node.advance())
    finally:
        node.close()


def main() -> None:
    """Run the cell until it is asked to stop."""
    run_node("cell", CellNode, spin)


if __name__ == "__main__":
    main()
