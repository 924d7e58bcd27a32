"""The wizard node: listens to the teacher and the robot, and publishes what an operator would."""

from __future__ import annotations

import time
from typing import Any

from builtin_interfaces.msg import Time
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.ros.conversions import prompt_from_msg, role_from_code, scene_from_msg, state_from_msg
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.ros.run_node import run_node
from mbd_msgs.msg import (
    CellTruth,
    Progress,
    Prompt,
    Scene,
    SessionState,
    Speech,
    WizardAnswer,
    WizardCommand,
    WizardDemonstration,
    WizardGripper,
    WizardHanded,
    WizardPointed,
    WizardReply,
)
from rclpy.clock import Clock, ClockType
from std_msgs.msg import Header

from mbd_cell.layout.placement import layout
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.parameters import WIZARD
from mbd_cell.ros.parameters import scene_folder
from mbd_cell.teacher.recognition import TrueTable
from mbd_cell.teacher.script import Word
from mbd_cell.teacher.wizard import Wizard, WizardAct, WizardEvent

PERIOD = 0.1  # [s] wall clock between two looks at what there is to do

COMMANDS: dict[WizardAct, tuple[type, int]] = {
    WizardAct.OPEN: (WizardGripper, WizardGripper.OPEN),
    WizardAct.CLOSE: (WizardGripper, WizardGripper.CLOSE),
    WizardAct.START: (WizardDemonstration, WizardDemonstration.START),
    WizardAct.STOP: (WizardDemonstration, WizardDemonstration.STOP),
    WizardAct.NEXT_PHASE: (WizardCommand, WizardCommand.NEXT_PHASE),
    WizardAct.REDO: (WizardCommand, WizardCommand.REDO),
    WizardAct.SKIP: (WizardCommand, WizardCommand.SKIP),
    WizardAct.YES: (WizardAnswer, WizardAnswer.YES),
    WizardAct.NO: (WizardAnswer, WizardAnswer.NO),
}


class WizardNode(TableNode):
    """Publishes wizard topics as a person would who knows the right answers."""

    def __init__(self, **options: Any) -> None:
        super().__init__(WIZARD, **options)
        self._scenes = scene_folder(self.values)
        self.wizard = Wizard(wrong_step=self.values["wrong_step"], reply_timeout=self.values["reply_timeout"])
        self._word_stamp: Time | None = None
        self._laid: dict[Role, tuple[str, int]] = {}
        self._finished = False
        self._out = {
            topic: self.create_publisher(kind, topic, EVENTS)
            for topic, kind in (
                ("wizard/gripper", WizardGripper),
                ("wizard/demonstration", WizardDemonstration),
                ("wizard/command", WizardCommand),
                ("wizard/answer", WizardAnswer),
                ("wizard/handed", WizardHanded),
                ("wizard/pointed", WizardPointed),
            )
        }
        self.create_subscription(Speech, "cell/speech", self._on_speech, EVENTS)
        self.create_subscription(CellTruth, "cell/truth", self._on_truth, LATCHED)
        self.create_subscription(SessionState, "interaction/state", self._on_state, LATCHED)
        self.create_subscription(Prompt, "interaction/prompt", self._on_prompt, LATCHED)
        self.create_subscription(WizardReply, "interaction/replies", self._on_reply, EVENTS)
        self.create_subscription(Progress, "interaction/progress", self._on_progress, LATCHED)
        for role in Role:
            self.create_subscription(Scene, f"perception/{role}_scene", self._on_scene, LATCHED)
        # The simulation's clock may stand still until this node acts, so it keeps its own time.
        self.create_timer(PERIOD, self._act, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _act(self) -> None:
        replies = self.count_publishers(self.resolve_topic_name("interaction/replies")) > 0
        robot = self.count_publishers(self.resolve_topic_name("interaction/progress")) > 0
        self.wizard.robot_at_work = robot and not self._finished
        request = self.wizard.next_request(time.monotonic(), replies)
        if request is not None:
            self._send(request)

    def _send(self, request: WizardEvent) -> None:
        self.get_logger().info(f"{request.act.value}: {request.why}")
        # What answers a word carries the word's time, whatever the delay on the way.
        stamp = (
            self._word_stamp
            if request.act in (WizardAct.OPEN, WizardAct.CLOSE, WizardAct.START, WizardAct.STOP)
            else None
        )
        header = Header(stamp=stamp or self.get_clock().now().to_msg())
        if request.act is WizardAct.HANDED:
            self._out[request.act.topic].publish(WizardHanded(header=header, object_id=request.object_id))
        elif request.act is WizardAct.POINTED:
            self._out[request.act.topic].publish(WizardPointed(header=header, object_id=request.object_id))
        else:
            kind, code = COMMANDS[request.act]
            field = "answer" if kind is WizardAnswer else "command"
            self._out[request.act.topic].publish(kind(header=header, **{field: code}))

    def _on_speech(self, msg: Speech) -> None:
        try:
            self.wizard.on_word(Word(msg.word))
        except ValueError:
            self.get_logger().error(f"cell/speech: unknown word {msg.word}")
            return
        self._word_stamp = msg.header.stamp

    def _on_truth(self, msg: CellTruth) -> None:
        places = {o.name: (o.pose.position.x, o.pose.position.y) for o in msg.objects}
        solution = {s.source_name: tuple(s.target_names) for s in msg.solution}
        role = role_from_code(msg.role)
        if self._laid.get(role) == (msg.task, msg.seed):
            return  # the same table after something was moved on it; what was seen on it stood where it was laid
        self._laid[role] = (msg.task, msg.seed)
        self.wizard.tables[role] = TrueTable(places, solution)
        if role is Role.TARGET and Role.SOURCE not in self.wizard.tables:
            self._recall_source(msg.task, msg.seed, solution)

    def _recall_source(self, task: str, seed: int, solution: dict[str, tuple[str, ...]]) -> None:
        """A wizard started after the source table was cleared works out how it was laid."""
        try:
            scenes = load_scenes(self._scenes / f"{task}.yaml")
            places = {p.name: (p.x, p.y) for p in layout(scenes, Role.SOURCE, seed)}
        except MbdError as error:
            self.get_logger().error(f"cannot find out how the source table was laid: {error}")
            return
        self.wizard.tables[Role.SOURCE] = TrueTable(places, solution)

    def _on_state(self, msg: SessionState) -> None:
        self.wizard.see_state(state_from_msg(msg))

    def _on_progress(self, msg: Progress) -> None:
        self._finished = msg.status == Progress.FINISHED

    def _on_prompt(self, msg: Prompt) -> None:
        self.wizard.see_prompt(prompt_from_msg(msg))

    def _on_scene(self, msg: Scene) -> None:
        try:
            scene = scene_from_msg(msg)
        except MbdError as error:
            self.get_logger().error(f"a perceived scene cannot be used: {error}")
            return
        self.wizard.scenes[scene.role] = scene

    def _on_reply(self, msg: WizardReply) -> None:
        request = self.wizard.reply(msg.topic, msg.accepted, time.monotonic())
        if request is not None and not msg.accepted:
            self.get_logger().warning(f"{request.act.value} was refused: {msg.reason}")


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("wizard", WizardNode)


if __name__ == "__main__":
    main()
