"""A film from a device of this machine goes with its bag, plays however it ended, and overwrites nothing."""

from __future__ import annotations

import json
import signal
import sys
import threading
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_model.room.device_report import DeviceReport, device_report
from mbd_model.room.recording import ClockMatch, RoomError, read_room_recording
from mbd_study.ros import room_device
from mbd_study.ros.room_device import session_folder

av = pytest.importorskip("av", reason="needs PyAV: requirements/recordings.txt")

from mbd_study.room.device.recording import FilmEnd, RoomDevices, new_film, waiting_frames  # noqa: E402
from mbd_study.room.device.source import DeviceSource, FrameClock  # noqa: E402
from mbd_study.room.offsets import film_offsets  # noqa: E402

APART = 1000.0  # [s] of the session's clock from the steady one
PICTURE, SOUND = "lavfi:testsrc=size=160x120:rate=10,realtime", "lavfi:sine=sample_rate=44100,arealtime"


class KeptNotes:
    """A session whose clock is the steady one, set otherwise."""

    def __init__(self) -> None:
        self.marked: dict[int, float] = {}
        self.reported: list[DeviceReport] = []

    def report(self, report: DeviceReport) -> None:
        self.reported.append(report)

    def look(self) -> ClockMatch:
        now = time.monotonic()
        return ClockMatch(now, now + APART, 1e-6)

    def mark(self, name: str, number: int, at: float) -> None:
        assert name == "room_1"
        self.marked[number] = at


def film(folder: Path, *devices: tuple[str, str], stop_after: float = 1e9) -> tuple[FilmEnd, KeptNotes]:
    """A film with lavfi's virtual devices; told to end a while after it began."""
    frames, session, begun = waiting_frames(), KeptNotes(), list[float]()
    sources = tuple(DeviceSource(kind, device, frames) for kind, device in devices)

    def stopped() -> bool:
        return bool(begun) and time.monotonic() > begun[0] + stop_after

    devices_of_room = RoomDevices(folder, sources, frames, session, stopped)
    return devices_of_room.film(lambda path: begun.append(time.monotonic())), session


def kinds(path: Path) -> dict[str, int]:
    """Frames of each kind that a player decodes."""
    found = {"video": 0, "audio": 0}
    with av.open(str(path)) as container:
        for packet in container.demux():
            found[packet.stream.type] += len(packet.decode())
    return found


def test_a_film_told_to_end_goes_with_its_bag_and_plays(tmp_path: Path):
    end, session = film(tmp_path, ("video", PICTURE), ("audio", SOUND), stop_after=1.5)
    assert (end.path, end.lost, end.signals) == (tmp_path / "room_1.webm", "", 2)
    recording = read_room_recording(tmp_path / "room_1.json")
    assert recording.ended
    growing, ended = DeviceReport("room_1", True, True), DeviceReport("room_1", True, True, ended=True)
    assert session.reported[:-1] == [growing] * (len(session.reported) - 1) and len(session.reported) > 2
    assert session.reported[-1] == ended
    found = film_offsets(end.path, recording, session.marked)
    assert [s.number for s in found.signals] == [1, 2]
    assert found.worst < 0.04
    frames = kinds(end.path)
    assert frames["video"] > 10
    assert frames["audio"] > 80


def test_a_device_that_is_lost_ends_the_film_in_a_sentence_and_the_film_plays(tmp_path: Path):
    (tmp_path / "room_1.webm").write_bytes(b"another film")
    end, session = film(tmp_path, ("video", "lavfi:testsrc=size=160x120:rate=10:duration=1,realtime"))
    assert session.reported[-1] == DeviceReport("room_2", sound=False, picture=True, lost=end.lost)
    assert end.path.name == "room_2.webm"
    assert end.lost.endswith("gives no more video")
    assert kinds(end.path)["video"] >= 8
    assert (tmp_path / "room_1.webm").read_bytes() == b"another film"
    assert json.loads((tmp_path / "room_2.json").read_text())["ended"] is True


def test_a_film_whose_writer_is_killed_plays_up_to_a_second_before(tmp_path: Path):
    taken: list[bytes] = []

    def copy() -> None:
        while not (tmp_path / "room_1.webm").exists() or (tmp_path / "room_1.webm").stat().st_size < 20_000:
            time.sleep(0.05)
        taken.append((tmp_path / "room_1.webm").read_bytes())

    copying = threading.Thread(target=copy, daemon=True)
    copying.start()
    noise = "lavfi:testsrc2=size=320x240:rate=20,noise=alls=60,realtime"
    film(tmp_path, ("video", noise), ("audio", SOUND), stop_after=2.5)
    copying.join(20)
    (tmp_path / "cut.webm").write_bytes(taken[0])
    assert kinds(tmp_path / "cut.webm")["video"] > 3


@pytest.mark.parametrize(
    ("kind", "device", "word"),
    [("video", "/dev/video97", "/dev/video97"), ("audio", "hw:97", "arecord"), ("audio", PICTURE, "gives no audio")],
)
def test_a_device_that_cannot_be_used_is_named(kind: str, device: str, word: str):
    with pytest.raises(RoomError, match=word):
        DeviceSource(kind, device, waiting_frames())


@given(st.booleans(), st.booleans(), st.sampled_from([(False, ""), (True, ""), (False, "the disk is full")]))
def test_a_report_says_the_same_to_who_reads_it(sound: bool, picture: bool, end: tuple[bool, str]):
    report = DeviceReport("room_3", sound, picture, *end)
    assert device_report(report.values, report.lost) == report


def test_a_film_gets_a_number_that_none_had(tmp_path: Path):
    (tmp_path / "room_1.json").write_text("{}")
    (tmp_path / "room_2.webm").write_text("")
    assert new_film(tmp_path).name == "room_3.webm"


def test_only_the_folder_of_a_bag_is_filmed_beside(tmp_path: Path):
    (tmp_path / "p01" / "bag").mkdir(parents=True)
    with pytest.raises(RoomError, match="holds no bag"):
        session_folder(tmp_path / "p01")
    (tmp_path / "p01" / "bag" / "bag_0.mcap").write_bytes(b"")
    assert session_folder(tmp_path / "p01") == session_folder(tmp_path / "p01" / "bag") == tmp_path / "p01"


@given(
    st.lists(st.floats(0.0, 0.3), min_size=20, max_size=60),
    st.one_of(st.just(None), st.floats(0.0, 1e6)),
    st.floats(1e3, 1e6),
)
def test_a_frame_keeps_its_moment_however_late_it_comes(lags: list[float], first: float | None, started: float):
    clock, wall = FrameClock(), 1.7e9
    for number, lag in enumerate((0.0, *lags)):
        moment = started + 0.05 * number
        came = moment + 0.05 + lag
        stamp = wall + 0.05 * number if first is None else first + 0.05 * number
        taken = clock.taken(stamp, 0.05, came, wall + 0.05 * number + 0.05 + lag)
        assert abs(taken - moment) < 1e-5


def test_the_command_says_what_it_lacks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.mcap").write_bytes(b"")
    before = signal.getsignal(signal.SIGINT)
    for words, said in (([], "nothing to film with"), (["--video", "/dev/video97"], "cannot be opened as video")):
        monkeypatch.setattr(sys, "argv", ["room_device", str(tmp_path), *words])
        with pytest.raises(SystemExit) as ended:
            room_device.main()
        assert ended.value.code == 2
        assert said in " ".join(capsys.readouterr().err.split())
    assert signal.getsignal(signal.SIGINT) is before
    assert not list(tmp_path.glob("room_*"))
