"""A session's tape as a bag: the messages that the nodes would have published, as a recorder would have kept them."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseStamped
from mbd_bag.images.image_cdr import COMPRESSED_IMAGE
from mbd_bag.images.image_compression import compress
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import full_definition, type_hash
from mbd_bag.storage.message_writer import EVENTS, LATCHED, SENSOR, MessageWriter
from mbd_cell.cell import Cell
from mbd_cell.physics.camera import Frame
from mbd_cell.ros import conversions as cell_convert
from mbd_interaction.events import Signal
from mbd_interaction.ros.conversions import ANSWERS, COMMANDS, DEMONSTRATION
from mbd_model import times
from mbd_model.ros import conversions as convert
from mbd_msgs import msg as m
from sensor_msgs.msg import CameraInfo, Image, JointState

WizardMessage = (
    m.WizardGripper
    | m.WizardDemonstration
    | m.WizardCommand
    | m.WizardHanded
    | m.WizardPointed
    | m.WizardAnswer
    | m.WizardNote
)

JPEG_QUALITY = 95
DRIVER = "j2n6s300_driver"
CODE_OF_COMMAND = {signal: code for code, signal in COMMANDS.items()}
CODE_OF_ANSWER = {signal: code for code, signal in ANSWERS.items()}
CODE_OF_DEMONSTRATION = {signal: code for code, signal in DEMONSTRATION.items()}


class BagTape:
    """Writes a simulated session to a bag while it happens.

    Args:
        session: its name.
        bag: new; the caller closes it.
    """

    def __init__(self, session: str, bag: BagWriter) -> None:
        self._session = session
        self._bag = bag
        self._writer = MessageWriter(bag)
        self._last = 0

    def write(self, topic: str, value: Any, at: int) -> None:
        """Record what a node would have published; times of the log never go back."""
        if topic == "camera":
            self._write_frame(value, at)
            return
        if topic == "robot":
            self._write_robot(value, at)
            return
        message = _message(topic, value, at, self._session)
        events = topic.startswith("wizard/") or topic in ("interaction/replies", "cell/speech", "study/form")
        self._put(f"/{topic}", message, at, EVENTS if events else LATCHED)

    def _put(self, topic: str, message: Any, at: int, qos: Any) -> None:
        self._last = max(self._last, at)
        self._writer.write(topic, message, self._last, qos)

    def _write_robot(self, cell: Cell, at: int) -> None:
        pose: PoseStamped = cell_convert.tool_pose_to_msg(cell)
        joints: JointState = cell_convert.joint_state_to_msg(cell)
        self._put(f"/{DRIVER}/out/tool_pose", pose, at, SENSOR)
        self._put(f"/{DRIVER}/out/joint_state", joints, at, SENSOR)

    def _write_frame(self, frame: Frame, at: int) -> None:
        info: CameraInfo = cell_convert.camera_info_to_msg(at)
        self._put("/camera/color/camera_info", info, at, SENSOR)
        self._write_image("/camera/color/image_raw", cell_convert.color_to_msg(frame, at))
        self._write_image("/camera/depth/image_raw", cell_convert.depth_to_msg(frame, at))

    def _write_image(self, topic: str, image: Image) -> None:
        small = compress(self._writer.encode(image), JPEG_QUALITY)
        if small is None:
            self._writer.write(topic, image, self._last, SENSOR)
            return
        name = topic + small.suffix
        record = TopicRecord(name, COMPRESSED_IMAGE, type_hash(COMPRESSED_IMAGE), (SENSOR,))
        self._bag.add_topic(record, full_definition(COMPRESSED_IMAGE))
        self._bag.write(name, self._last, small.data)


def _message(topic: str, value: Any, at: int, session: str) -> Any:
    """The message of a topic whose values the tape takes."""
    seconds = times.to_seconds(at)
    if topic == "interaction/state":
        return convert.state_to_msg(value, seconds)
    if topic == "interaction/prompt":
        return convert.prompt_to_msg(value, seconds)
    if topic == "interaction/assists":
        message: m.Assists | m.WizardReply | m.Progress | WizardMessage = convert.assists_to_msg(
            value[0], seconds, session, value[1]
        )
    elif topic == "interaction/replies":
        message = m.WizardReply(topic=value.topic, accepted=value.accepted, reason=value.reason)
    elif topic == "mapping/estimate":
        estimate, inputs = value
        stamps = (
            convert.stamp_to_msg(inputs.task_stamp),
            convert.stamp_to_msg(inputs.scene_stamp),
            convert.stamp_to_msg(inputs.assists_stamp),
        )
        return convert.estimate_to_msg(estimate, session=session, threshold=inputs.threshold, stamps=stamps)
    elif topic == "demonstration/task":
        return convert.task_to_msg(value)
    elif topic.startswith("perception/"):
        return convert.scene_to_msg(*value)
    elif topic == "interaction/progress":
        progress, assists_stamp = value
        message = convert.progress_to_msg(progress, session, convert.stamp_to_msg(assists_stamp))
    elif topic == "study/form":
        filled, phase, opened = value
        return convert.form_to_msg(filled, session, phase, (opened, seconds))
    elif topic == "cell/truth":
        return cell_convert.truth_to_msg(value)
    elif topic == "cell/speech":
        return cell_convert.speech_to_msg(value, at)
    else:
        message = _wizard_message(topic, value)
    message.header.stamp = convert.stamp_to_msg(at)
    return message


def _wizard_message(topic: str, value: Any) -> WizardMessage:
    if topic == "wizard/note":
        return m.WizardNote(text=value)
    if topic == "wizard/gripper":
        return m.WizardGripper(command=int(value))
    if topic == "wizard/demonstration":
        return m.WizardDemonstration(command=CODE_OF_DEMONSTRATION[value])
    if topic == "wizard/answer":
        return m.WizardAnswer(answer=CODE_OF_ANSWER[value])
    if topic == "wizard/command":
        return m.WizardCommand(command=CODE_OF_COMMAND[value])
    kind = m.WizardHanded if topic == f"wizard/{Signal.HANDED}" else m.WizardPointed
    return kind(object_id=value)
