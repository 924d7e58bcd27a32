"""Sound and picture of the room, from a browser's camera and microphone to a file that goes with the session's bag."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from console_browser import CHROMIUM, DRIVER, Browser
from console_stage import Stage, console_stage
from mbd_bag.storage.bag import Bag
from mbd_bringup.nodes import NodeSpec
from mbd_model.room.recording import read_room_recording
from mbd_study.room import room_sync_command
from mbd_study.room.films import marked_signals

pytestmark = [
    pytest.mark.alone,
    pytest.mark.timeout(300),
    pytest.mark.skipif(
        not (CHROMIUM.exists() and DRIVER.exists()), reason="needs a browser: apt-get install chromium chromium-driver"
    ),
]
# Chromium's own camera (a clock) and microphone (a beep twice a second), given without a question.
DEVICES = ("--use-fake-device-for-media-stream=fps=5", "--use-fake-ui-for-media-stream")


def test_the_room_is_recorded_beside_the_bag_by_keyboard_and_within_40_ms_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    pytest.importorskip("av", reason="needs PyAV: requirements/recordings.txt")
    folder = tmp_path / "session"
    recorder = NodeSpec("mbd_bag", "recorder", {"bag": str(folder / "bag")})
    with console_stage(tmp_path, {"room_dir": str(folder)}, beside=(recorder,)) as stage:
        stage.rest()
        browser = Browser(stage.address, tmp_path / "profile", flags=DEVICES)
        try:
            film_by_keyboard(stage, browser)
            stage.others.wait_for(lambda: read_room_recording(folder / "room_2.json").ended)
        finally:
            browser.close()
        stage.processes.stop()
    recording = read_room_recording(folder / "room_1.json")
    assert recording.ended and len(recording.signals) == 2
    assert sorted(marked_signals(Bag(folder / "bag"))["room_1"]) == [1, 2]
    assert (folder / "room_2.webm").stat().st_size > 10_000  # its page was closed amid it
    monkeypatch.setattr(sys, "argv", ["room_sync", str(folder)])
    with pytest.raises(SystemExit) as ended:
        room_sync_command.main()
    said = capsys.readouterr().out
    assert ended.value.code == 0, said
    assert said.count("sound and picture; at most") == 2 and said.count("the film has it") == 3, said


def film_by_keyboard(stage: Stage, browser: Browser) -> None:
    """One film from switch to switch, and one whose page is closed."""
    browser.says(".lamps", "recording", "the page does not show that a recorder runs")
    browser.key("v")
    switch = "document.getElementById('room-switch')"
    assert browser.driver.execute_script(f"return {switch}.ariaChecked") == "false"
    assert "ROOM IS RECORDED" not in browser.text(".lamps")
    for name in ("room_1", "room_2"):
        browser.driver.execute_script(f"{switch}.focus()")
        browser.key(" ")
        browser.says(".lamps", "ROOM IS RECORDED", "the bar does not say that the room is recorded")
        browser.says("#room-said", "Test signal 1", f"{name} has no test signal")
        if name == "room_1":
            browser.driver.execute_script(f"{switch}.focus()")
            browser.key(" ")
            browser.says("#room-said", "room_1.webm is complete")
    # So much later that the chunk with the test signal has come.
    sizes = "return performance.getEntriesByType('resource').filter(e => /room_2\\/[0-9]+/.test(e.name)).length"
    browser.wait(lambda: browser.driver.execute_script(sizes) >= 4, "no chunks are sent")
    browser.show("about:blank")
