"""``room_device SESSION --video /dev/video0 --audio hw:0``: film the room with devices of this machine, beside a bag.

Ctrl-C ends the film. Only with the consent of everybody in the room; the session's pages say that it is filmed, and
when the film broke off.
"""

from __future__ import annotations

import signal
import sys
import threading
import time
from argparse import RawDescriptionHelpFormatter
from pathlib import Path
from types import FrameType

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from mbd_bag.session.command_line import note, run_tool
from mbd_model.command_line.parser import CommandParser
from mbd_model.room.device_report import STATUS, DeviceReport
from mbd_model.room.recording import SIGNAL_MARKER, ClockMatch, RoomError, signal_words
from mbd_model.ros import conversions
from mbd_model.ros.qos import EVENTS
from mbd_model.ros.starting.command_line import init_ros, other_words
from mbd_msgs.msg import WizardNote
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rich.console import Console
from std_msgs.msg import Header

from mbd_study.room.device.recording import RoomDevices, waiting_frames
from mbd_study.room.device.source import DeviceSource

LOST = 1
LISTENED = 5.0  # [s] until a recorder that takes notes is to be found


class RoomSession:
    """The session as a film needs it: its clock, and notes in its bag.

    Args:
        node: whose clock is the session's.
    """

    def __init__(self, node: Node) -> None:
        self._clock = node.get_clock()
        self._notes = node.create_publisher(WizardNote, "wizard/note", EVENTS)
        self._diagnostics = node.create_publisher(DiagnosticArray, "diagnostics", EVENTS)

    def listened(self) -> bool:
        """Whether anybody takes notes, within some seconds."""
        end = time.monotonic() + LISTENED
        while not self._notes.get_subscription_count() and time.monotonic() < end:
            time.sleep(0.1)
        return self._notes.get_subscription_count() > 0

    def look(self) -> ClockMatch:
        """The steady clock and the session's at one moment."""
        before = time.monotonic()
        session = conversions.clock_seconds(self._clock)
        after = time.monotonic()
        return ClockMatch((before + after) / 2, session, (after - before) / 2)

    def mark(self, name: str, number: int, at: float) -> None:
        """Publish the note that marks a test signal; ``at``: [s, session clock]."""
        header = Header(stamp=conversions.time_to_msg(at))
        self._notes.publish(WizardNote(header=header, text=signal_words(name, number), marker=SIGNAL_MARKER))

    def report(self, report: DeviceReport) -> None:
        """Publish how the film stands, for the session's pages."""
        level = DiagnosticStatus.ERROR if report.lost else DiagnosticStatus.OK
        words = report.lost or ("the film has ended" if report.ended else "the room is filmed")
        values = [KeyValue(key=key, value=value) for key, value in report.values.items()]
        status = DiagnosticStatus(level=level, name=STATUS, message=words, values=values)
        stamp = conversions.time_to_msg(conversions.clock_seconds(self._clock))
        self._diagnostics.publish(DiagnosticArray(header=Header(stamp=stamp), status=[status]))
        if report.ended or report.lost:
            self._diagnostics.wait_for_all_acked(Duration(seconds=LISTENED))  # this process ends next


def session_folder(path: Path) -> Path:
    """The folder in which films of a session lie: that which holds its bag; raises RoomError when there is no bag."""
    if _is_bag(path):
        return path.resolve().parent
    if path.is_dir() and any(_is_bag(inner) for inner in path.iterdir() if inner.is_dir()):
        return path.resolve()
    raise RoomError(f"{path} holds no bag; expected the folder of a session that is being recorded, as in sessions/p01")


def _is_bag(folder: Path) -> bool:
    return folder.is_dir() and any(any(folder.glob(ending)) for ending in ("*.mcap", "*.db3", "metadata.yaml"))


def _film() -> int:
    parser = CommandParser(prog="room_device", description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("session", type=Path, help="folder of the session, or its bag")
    parser.add_argument("--video", help="camera: /dev/video0, or of another FFmpeg device: x11grab::0")
    parser.add_argument("--audio", help="microphone: hw:0, or of another FFmpeg device: oss:/dev/dsp")
    parser.add_argument("--size", help="of the camera's pictures [px], such as 1280x720; its own choice without")
    arguments = parser.parse_args(other_words(sys.argv[1:]))
    if not (arguments.video or arguments.audio):
        raise RoomError("nothing to film with: give --video, --audio, or both")
    folder = session_folder(arguments.session)
    console, frames, ended = Console(), waiting_frames(), threading.Event()
    sources = []
    if arguments.video:
        options = {"video_size": arguments.size} if arguments.size else {}
        sources.append(DeviceSource("video", arguments.video, frames, options))
    if arguments.audio:
        sources.append(DeviceSource("audio", arguments.audio, frames))
    init_ros(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)

    def end(number: int, frame: FrameType | None) -> None:
        del number, frame
        ended.set()

    signal.signal(signal.SIGINT, end)
    signal.signal(signal.SIGTERM, end)
    node = rclpy.create_node("room_device")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    try:
        session = RoomSession(node)
        if not session.listened():
            unsaid = "its pages do not say that the room is filmed, and no test signal is marked in its bag"
            note(f"nobody of this session listens (ROS_DOMAIN_ID?): {unsaid}", console)
        if not arguments.audio:
            note("without --audio no test signal is recorded: that film and bag go together is not measured", console)

        def begun(path: Path) -> None:
            console.print(f"films to {path.name}; Ctrl-C ends", highlight=False, markup=False, soft_wrap=True)

        film = RoomDevices(folder, tuple(sources), frames, session, ended.is_set).film(begun)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    words = f"wrote {film.seconds:.0f} s to {film.path}, {film.signals} test signals"
    console.print(words, highlight=False, markup=False, soft_wrap=True)
    if film.dropped:
        note(f"{film.dropped} frames were left out: the machine was too busy", console)
    if film.lost:
        Console(stderr=True).print(f"room_device: {film.lost}; the film ends there", highlight=False, markup=False)
    return LOST if film.lost else 0


def main() -> None:
    """Entry point: exit code 0; 1 when a device was lost; 2 when nothing can be filmed."""
    run_tool("room_device", _film)
