"""Node ``console``: follows the session for the web pages and publishes what the operator presses."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from mbd_model.camera.parameters import camera_pose
from mbd_model.camera.view import CameraView
from mbd_model.objects import Scene
from mbd_model.room import device_report
from mbd_model.room.recording import SIGNAL_MARKER
from mbd_model.ros import conversions
from mbd_model.ros.latch import make_state_folder
from mbd_model.ros.offered import OfferedSubscription, image_sources
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_model.ros.stop_line import StopLine
from mbd_model.session import Phase, SessionState
from mbd_model.stop import StopCause, StopLatch
from mbd_msgs import msg as m
from mbd_perception.ros.camera_conversions import color_from_msg
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from mbd_console import state as console_state
from mbd_console.desk import Change, Desk
from mbd_console.parameters import CONSOLE
from mbd_console.requests import ConsoleRequest, StopRobot
from mbd_console.restart.kept_console import KeptConsole
from mbd_console.room.store import RoomStore
from mbd_console.ros.wizard_words import WizardWords
from mbd_console.state import ConsoleState
from mbd_console.status.recorder import STATUS, recorder_state
from mbd_console.study import board as study_board
from mbd_console.study.form_plan import form_plan
from mbd_console.study.offered import OfferedSession

Message = TypeVar("Message")

WORDS = {
    m.Speech.OPEN: "open",
    m.Speech.CLOSE: "close",
    m.Speech.DEMONSTRATION_BEGINS: "I begin",
    m.Speech.DEMONSTRATION_ENDS: "I have finished",
    m.Speech.READY: "the table is ready",
}
COLOR_TOPIC = "camera/color/image_raw"


class ConsoleNode(TableNode):
    """Subscribes to what a session publishes and posts it to a desk; sends the desk's requests as wizard topics."""

    def __init__(self, **options: Any) -> None:
        super().__init__(CONSOLE, **options)
        self.host: str = self.values["host"]
        self.port: int = self.values["port"]
        self._pose = camera_pose(self.values)
        self._kept = self._kept_console(self.values["state_dir"])
        self.desk = Desk(
            self._send,
            self._now,
            forms=form_plan(self.values["forms"]),
            language=self.values["language"],
            room=RoomStore(Path(folder) if (folder := self.values["room_dir"]) else None, time.monotonic),
            on_change=self._on_change,
        )
        self._words = WizardWords(self)
        self._stop = StopLine(self, self._on_stop)
        self._halt = self.create_guard_condition(self._on_halt)
        self._listen(m.SessionState, "interaction/state", LATCHED, self._session)
        self._listen(m.Prompt, "interaction/prompt", LATCHED, self._prompt)
        self._listen(m.Scene, "perception/source_scene", LATCHED, self._scene)
        self._listen(m.Scene, "perception/target_scene", LATCHED, self._scene)
        self._listen(m.Task, "demonstration/recorded", LATCHED, self._recorded)
        self._listen(m.Task, "demonstration/task", LATCHED, self._task)
        self._listen(m.MappingEstimate, "mapping/estimate", LATCHED, self._estimate)
        self._listen(m.Progress, "interaction/progress", LATCHED, self._progress)
        self._listen(m.WizardReply, "interaction/replies", EVENTS, self._reply)
        self._listen(m.WizardGripper, "wizard/gripper", EVENTS, self._gripper)
        self._listen(m.WizardNote, "wizard/note", EVENTS, self._written)
        self._listen(m.FilledForm, "study/form", EVENTS, self._form)
        self._listen(m.Speech, "cell/speech", EVENTS, self._speech)
        self._listen(m.NextSession, "session/next", LATCHED, self._next)
        self._listen(DiagnosticArray, "diagnostics", EVENTS, self._diagnostics)
        self._listen(CameraInfo, "camera/color/camera_info", SENSOR, self._info)
        images = image_sources(
            self, COLOR_TOPIC, Image, CompressedImage, suffixes=["/compressed"], transport="auto"
        )  # fmt: skip
        OfferedSubscription(self, images, self._posting(COLOR_TOPIC, self._image))

    def _kept_console(self, state_dir: str) -> KeptConsole | None:
        """What survives a restart; raises MbdError when the folder cannot be used."""
        if not state_dir:
            return None
        make_state_folder(Path(state_dir))
        kept = KeptConsole(Path(state_dir))
        if word := kept.set_aside_unreadable():
            self.get_logger().error(word)
        return kept

    def _on_change(self, before: ConsoleState, after: ConsoleState) -> None:
        """Write down what must survive, when it is other than before."""
        same = before.phase is after.phase and before.study == after.study and before.began == after.began
        if self._kept is None or same:
            return
        try:
            self._kept.keep(after)
        except OSError as error:
            self.get_logger().error(f"what the console shows would not survive its restart: {error}")

    def _on_stop(self, latch: StopLatch) -> None:
        at, why = self._now(), (latch.reason or "stopped") if latch.held else ""
        self.desk.post(lambda state: console_state.on_stop(state, why, at))

    def _on_halt(self) -> None:
        self._stop.stop(StopCause.PERSON, "a hand on the console's stop")

    def _now(self) -> float:
        return conversions.clock_seconds(self.get_clock())

    def _listen(
        self, kind: type[Message], topic: str, qos: QoSProfile, change: Callable[[Message], Change | None]
    ) -> None:
        """Post what each message changes."""
        self.create_subscription(kind, topic, self._posting(topic, change), qos)

    def _posting(self, topic: str, change: Callable[[Message], Change | None]) -> Callable[[Message], None]:
        """Posts what a message changes; one that cannot be is logged and changes nothing."""

        def on_message(msg: Message) -> None:
            try:
                changed = change(msg)
            except ValueError as error:  # MbdError is one
                self.get_logger().error(f"{topic} is unusable and ignored: {error}")
                return
            if changed is not None:
                self.desk.post(changed)

        return on_message

    def _session(self, msg: m.SessionState) -> Change:
        session, at = conversions.state_from_msg(msg), conversions.time_from_msg(msg.header.stamp)
        return lambda state: self._entered(state, session, at)

    def _entered(self, state: ConsoleState, session: SessionState, at: float) -> ConsoleState:
        """The state with the dialogue's; the clock of before for a session that was known before a restart."""
        shown = console_state.on_session(state, session, at)
        first = state.session is None or state.session.session != session.session
        kept = self._kept.restored(shown) if first and self._kept is not None else None
        if kept is not None:
            began, phase_began, board = kept
            shown = replace(shown, began=began, phase_began=phase_began, study=board)
        if state.phase is not shown.phase or first:
            study = study_board.due(shown.study, self.desk.forms, session.phase, self._now())
            shown = console_state.on_study(shown, study)
        return shown

    def _prompt(self, msg: m.Prompt) -> Change:
        prompt, at = conversions.prompt_from_msg(msg), conversions.time_from_msg(msg.header.stamp)
        return lambda state: console_state.on_prompt(state, prompt, at)

    def _scene(self, msg: m.Scene) -> Change:
        scene = conversions.scene_from_msg(msg)
        a, b, c, d = (float(v) for v in msg.table_plane)
        self._photograph(scene)
        return lambda state: console_state.on_scene(state, scene, (a, b, c, d))

    def _photograph(self, scene: Scene) -> None:
        """Show the picture in which a scene was observed: the camera's, else the one kept before a restart."""
        picture = self.desk.pictures.keep(scene.role, scene.stamp)
        if self._kept is None:
            return
        if picture is None:
            before = self._kept.picture(scene.role, scene.stamp)
            if before is not None:
                self.desk.pictures.show(scene.role, before)
            return
        try:
            self._kept.keep_picture(scene.role, scene.stamp, picture)
        except OSError as error:
            self.get_logger().error(f"the picture of the {scene.role} scene would not survive a restart: {error}")

    def _next(self, msg: m.NextSession) -> Change:
        offered = OfferedSession(msg.session, msg.participant, msg.task, msg.condition, msg.problem)
        return lambda state: console_state.on_offered(state, offered)

    def _form(self, msg: m.FilledForm) -> Change:
        name, declined = msg.form, bool(msg.declined)
        return lambda state: console_state.on_study(state, study_board.came_back(state.study, name, declined))

    def _recorded(self, msg: m.Task) -> Change:
        task = conversions.task_from_msg(msg)
        return lambda state: console_state.on_recorded(state, task)

    def _task(self, msg: m.Task) -> Change:
        task = conversions.task_from_msg(msg)
        self.desk.moments.keep([s.end for s in task.steps])
        return lambda state: console_state.on_task(state, task)

    def _estimate(self, msg: m.MappingEstimate) -> Change:
        estimate, at = conversions.estimate_from_msg(msg), time.monotonic()
        return lambda state: console_state.on_estimate(state, estimate, float(msg.threshold), bool(msg.confident), at)

    def _progress(self, msg: m.Progress) -> Change:
        progress, at = conversions.progress_from_msg(msg), self._now()
        return lambda state: console_state.on_progress(state, progress, msg.session, at)

    def _reply(self, msg: m.WizardReply) -> Change:
        at = self._now()
        return lambda state: console_state.on_reply(state, msg.topic, msg.accepted, msg.reason, at)

    def _gripper(self, msg: m.WizardGripper) -> Change:
        return lambda state: console_state.on_gripper(state, msg.command == m.WizardGripper.CLOSE)

    def _written(self, msg: m.WizardNote) -> Change:
        at = self._now()
        text = f"test signal of the room: {msg.text}" if msg.marker == SIGNAL_MARKER else msg.text
        return lambda state: console_state.on_note(state, text, at)

    def _speech(self, msg: m.Speech) -> Change:
        words, at = WORDS.get(msg.word, f"word {msg.word}"), self._now()
        return lambda state: console_state.on_speech(state, int(msg.word), words, at)

    def _diagnostics(self, msg: DiagnosticArray) -> Change | None:
        """What the recorder and films by devices report; the other nodes' reports are for other tools."""
        for status in msg.status:
            values = {v.key: v.value for v in status.values}
            if status.name == device_report.STATUS:
                report = device_report.device_report(values, str(status.message))
                now, at = time.monotonic(), self._now()
                return lambda state: console_state.on_filmed(state, report, now, at)
            if status.name == STATUS:
                recorder = recorder_state(values, str(status.message), time.monotonic())
                return lambda state: console_state.on_recorder(state, recorder)
        return None

    def _info(self, msg: CameraInfo) -> Change | None:
        intrinsics = (float(msg.k[0]), float(msg.k[4]), float(msg.k[2]), float(msg.k[5]))
        size = (int(msg.width), int(msg.height))
        if not all(size) or not msg.k[0] or not msg.k[4]:
            return None  # a camera that was never calibrated has no outlines
        known = self.desk.state.view
        if known is not None and (known.intrinsics, known.size) == (intrinsics, size):
            return None
        view = CameraView(intrinsics, size, self._pose)
        return lambda state: console_state.on_view(state, view)

    def _image(self, msg: Image | CompressedImage) -> None:
        stamp, picture = conversions.time_from_msg(msg.header.stamp), color_from_msg(msg)
        self.desk.pictures.add(stamp, picture)
        if self.desk.state.phase is Phase.DEMONSTRATE:
            self.desk.moments.add(stamp, picture)

    def _send(self, request: ConsoleRequest) -> None:
        """Publish a request, from any thread."""
        if isinstance(request, StopRobot):
            self._halt.trigger()  # in the node's own thread, as all that touches the latch
        else:
            self._words.publish(request, self.desk.state)
