"""The test signal is found where it was played, and a film that does not go with its bag is named."""

from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_bag.ros.session_conversions import session_to_bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import EVENTS, MessageWriter
from mbd_model.room.chirp import BY_AIR_AFTER, chirp
from mbd_model.room.recording import SIGNAL_MARKER, ClockMatch, RoomRecording, as_text, room_recording, signal_words
from mbd_msgs.msg import WizardNote
from mbd_study.room import room_sync_command
from mbd_study.room.beep import find_beep
from mbd_study.room.film_sound import RATE
from mbd_study.sharing import share_command
from mbd_study.synthetic import CAMERA, session

av = pytest.importorskip("av", reason="needs PyAV: requirements/recordings.txt")


@settings(max_examples=25, deadline=None)
@given(
    place=st.integers(0, RATE), loudness=st.floats(0.03, 1.0), seed=st.integers(0, 99), rising=st.booleans(),
    rate=st.sampled_from([16_000, 44_100, RATE]),
)  # fmt: skip
def test_a_chirp_as_loud_as_the_noise_is_found_to_a_millisecond(
    place: int, loudness: float, seed: int, rising: bool, rate: int
):
    sound = np.random.default_rng(seed).normal(0.0, loudness / np.sqrt(2.0), 2 * RATE)
    played = chirp(rate, rising=rising)
    sound[place : place + len(played)] += loudness * played
    found = find_beep(sound, rate, rising=rising)
    assert found is not None and abs(found.at - place / rate) < 1e-3


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 999), pitch=st.floats(80.0, 4000.0), tone=st.floats(0.0, 3.0), rising=st.booleans())
def test_noise_tones_speech_like_sound_and_the_other_chirp_are_no_signal(
    seed: int, pitch: float, tone: float, rising: bool
):
    rng = np.random.default_rng(seed)
    t = np.arange(2 * RATE) / RATE
    # Harmonics under an envelope of syllables, a beep that begins and ends at once, noise.
    voice = sum(np.sin(2 * np.pi * pitch * k * t) / k for k in range(1, 8)) * np.abs(np.sin(2 * np.pi * 4.0 * t))
    sound = tone * voice + rng.normal(0.0, 0.1, len(t))
    sound[RATE : RATE + RATE // 8] += tone * np.sin(2 * np.pi * pitch * t[: RATE // 8])
    other = chirp(RATE, rising=not rising)
    sound[RATE // 2 : RATE // 2 + len(other)] += other
    assert find_beep(sound, RATE, rising=rising) is None


def test_silence_and_a_sound_shorter_than_the_signal_have_none():
    assert find_beep(np.zeros(RATE), RATE, rising=True) is None
    assert find_beep(np.ones(100), RATE, rising=True) is None


START = 5.0  # [s, the browser's clock] of the film's time 0
RECORDING = room_recording(
    {"started": START, "clock": [[5.0, 1005.0, 0.002]], "signals": [[1, 6.0, 0.03], [2, 9.0, 0.03]], "ended": True}
)


def film(path: Path, late: float = 0.0, air: float | None = None, seconds: float = 6.0) -> None:
    """WebM as a browser writes it: noise with the recording's signals, and a few pictures."""
    sound = np.random.default_rng(1).normal(0.0, 0.02, round(seconds * RATE))
    rising, falling = chirp(RATE, rising=True), chirp(RATE, rising=False)
    for signal in RECORDING.signals:
        moments = [(signal.browser - START + late, 0.25 * rising)]
        if air is not None:
            moments.append((signal.browser - START + late + BY_AIR_AFTER + signal.latency + air, 0.05 * falling))
        for moment, played in moments:
            first = round(moment * RATE)
            part = played[: max(0, len(sound) - first)]
            sound[first : first + len(part)] += part
    with av.open(str(path), "w", format="webm") as made:
        voice = made.add_stream("libopus", rate=RATE, layout="mono")
        eyes = made.add_stream("libvpx", rate=10, width=64, height=48, pix_fmt="yuv420p")
        for k in range(5):
            picture = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 40 * k, np.uint8), format="rgb24")
            made.mux(eyes.encode(picture))
        made.mux(eyes.encode())
        for first in range(0, len(sound) - 959, 960):
            frame = av.AudioFrame.from_ndarray(sound[None, first : first + 960].astype(np.float32), "flt", "mono")
            frame.sample_rate, frame.pts, frame.time_base = RATE, first, Fraction(1, RATE)
            made.mux(voice.encode(frame))
        made.mux(voice.encode())


def filmed_session(folder: Path, late_marks: float = 0.0, recording: RoomRecording | None = RECORDING) -> Path:
    """A synthetic session's bag with the marks of the signals, and what lies beside a film."""
    made = session("p01_sorting", np.random.default_rng(1))
    folder.mkdir()
    with BagWriter(folder / "bag") as bag:
        session_to_bag(made.recorded, bag, made.pictures, CAMERA)
        writer = MessageWriter(bag)
        for signal in RECORDING.signals:
            at = RECORDING.session_time(signal.browser) + late_marks
            note = WizardNote(text=signal_words("room_1", signal.number), marker=SIGNAL_MARKER)
            note.header.stamp.sec, note.header.stamp.nanosec = int(at), round(at % 1.0 * 1e9)
            writer.write("/wizard/note", note, bag.last_log_time + 1, EVENTS)
    if recording is not None:
        (folder / "room_1.json").write_text(as_text(recording, "room_1.webm"))
    return folder


def run(monkeypatch: pytest.MonkeyPatch, tool: object, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["tool", *words])
    with pytest.raises(SystemExit) as ended:
        tool.main()  # type: ignore[attr-defined]
    return int(ended.value.code or 0)


def test_a_film_that_goes_with_its_bag_is_measured_and_one_60_ms_off_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    good, late = filmed_session(tmp_path / "good"), filmed_session(tmp_path / "late", late_marks=0.06)
    film(good / "room_1.webm", late=0.012, air=0.02)
    film(late / "room_1.webm")
    assert run(monkeypatch, room_sync_command, str(good)) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "6 s of sound and picture" in said and "within 40 ms" in said
    offsets = [float(words.split()[0]) for words in said.split("the film has it ")[1:]]
    # What the coder holds back is 6.5 ms at most.
    assert len(offsets) == 2 and all(abs(offset - 12.0) < 7.0 for offset in offsets)
    added = [float(words.split()[0]) for words in said.split("microphone add ")[1:]]
    assert len(added) == 2 and all(abs(ms - 20.0) < 2.0 for ms in added)
    assert run(monkeypatch, room_sync_command, str(late / "bag")) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "before the bag" in said and "MORE than 40 ms" in said and "did not pick up the speaker" in said
    assert run(monkeypatch, room_sync_command, str(tmp_path)) == 1  # both: one of them is off


def test_a_film_that_broke_off_is_measured_as_far_as_it_goes_and_what_is_none_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    folder = filmed_session(tmp_path / "p01")
    film(folder / "room_1.webm")
    complete = (folder / "room_1.webm").read_bytes()
    (folder / "room_1.webm").write_bytes(complete[: len(complete) // 2])
    assert run(monkeypatch, room_sync_command, str(folder)) == 0
    said = capsys.readouterr().out
    assert "test signal 1: the film has it" in said and "test signal 2: it is not in the film" in said
    film(tmp_path / "short.webm", seconds=0.5)
    short = (tmp_path / "short.webm").read_bytes()
    for data, words in ((b"", "is empty"), (short, "no test signal"), (complete[:200], "cannot be")):
        (folder / "room_1.webm").write_bytes(data)
        assert run(monkeypatch, room_sync_command, str(folder)) == 1
        assert words in " ".join(capsys.readouterr().out.split())
    (folder / "room_1.json").write_text("[]")
    assert run(monkeypatch, room_sync_command, str(folder)) == 1
    assert "beside the film" in " ".join(capsys.readouterr().out.split())
    (folder / "room_1.webm").unlink()
    assert run(monkeypatch, room_sync_command, str(folder)) == 2
    assert "no film room_<n>.webm" in " ".join(capsys.readouterr().err.split())
    assert run(monkeypatch, room_sync_command, str(tmp_path / "nowhere")) == 2
    assert "there is no" in " ".join(capsys.readouterr().err.split())


def test_a_shared_copy_has_no_film_and_says_so_also_where_the_bag_alone_was_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    folder = filmed_session(tmp_path / "study")
    (folder / "room_1.webm").write_bytes(b"film")
    for number, given_path in enumerate((folder, folder / "bag")):
        out = tmp_path / f"shared_{number}"
        assert run(monkeypatch, share_command, str(given_path), "--out", str(out)) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert "room_1.webm" in said and "1 films of the room lie beside the bags" in said
        assert [p.name for p in out.rglob("*room*")] == []


@given(st.floats(-2e-4, 2e-4), st.lists(st.floats(-0.004, 0.004), min_size=181, max_size=181))
def test_over_half_an_hour_two_clocks_may_drift_apart_and_stay_within_40_ms(drift: float, errors: list[float]):
    """By timestamps: a look at both clocks every 10 s, each wrong by up to 4 ms; one clock up to 200 ppm too fast."""
    looks = tuple(ClockMatch(10.0 * k * (1 + drift), 5000.0 + 10.0 * k + e, 0.004) for k, e in enumerate(errors))
    recording = RoomRecording(0.0, looks)
    apart = [abs(recording.session_time(t * (1 + drift)) - (5000.0 + t)) for t in range(0, 1800, 7)]
    assert max(apart) <= 0.004 + 5.0 * abs(drift) * 1.01 + 1e-9 < 0.04
    once = RoomRecording(0.0, looks[:1])
    assert abs(once.session_time(1800.0 * (1 + drift)) - 6800.0) >= 1800.0 * abs(drift) - 0.004 - 1e-9  # why it is done
