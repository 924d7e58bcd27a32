"""A frame that cannot be seen through is kept, and nothing ends for it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from mbd_model.camera.intrinsics import Intrinsics
from mbd_perception.frames.evidence import MOST, keep_evidence
from mbd_perception.frames.files import load_depth_scale, load_frame
from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame
from mbd_perception.tools import segment_frames

CAMERA = Intrinsics(500.0, 500.0, 3.5, 2.5, width=8, height=6)


def small_frame() -> RgbdFrame:
    """Any frame."""
    depth = np.full((6, 8), 900, dtype=np.uint16)
    depth[0, 0] = 0
    return make_frame(np.full((6, 8, 3), 77, dtype=np.uint8), depth, CAMERA)


def test_kept_frame_loads_again(tmp_path: Path) -> None:
    """What is kept is a frame folder, equal to the frame up to half a millimetre, with the traceback beside it."""
    folder = keep_evidence(tmp_path / "failed", ValueError("odd"), small_frame())
    assert folder is not None
    again = load_frame(folder)
    np.testing.assert_allclose(again.depth, small_frame().depth, atol=5e-4)
    np.testing.assert_array_equal(again.color, small_frame().color)
    assert "ValueError: odd" in (folder / "error.txt").read_text()


def test_not_more_than_some(tmp_path: Path) -> None:
    """A camera that fails on every frame does not fill the disk."""
    kept = [keep_evidence(tmp_path, ValueError("odd"), None) for _ in range(MOST + 2)]
    assert kept[MOST:] == [None, None]
    assert len(list(tmp_path.iterdir())) == MOST


def test_nowhere_to_write(tmp_path: Path) -> None:
    """Where nothing can be written nothing fails."""
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    assert keep_evidence(blocked, ValueError("odd"), small_frame()) is None


def test_saturated_is_no_distance() -> None:
    """65535 is no return, whatever its neighbours are."""
    depth = np.full((6, 8), 900, dtype=np.uint16)
    depth[2, 3] = 65535
    frame = make_frame(np.zeros((6, 8, 3), dtype=np.uint8), depth, CAMERA)
    assert frame.depth[2, 3] == 0
    assert np.count_nonzero(frame.depth) == 47


@pytest.mark.parametrize("value", ["0", "-1", '"mm"', "true", "1000"])
def test_odd_depth_scale(tmp_path: Path, value: str) -> None:
    """A depth_scale that is no number of metres is refused, naming the file."""
    meta = tmp_path / "meta.json"
    meta.write_text('{"camera": {"depth_scale": ' + value + "}}")
    with pytest.raises(FrameError, match=r"meta\.json.*depth_scale"):
        load_depth_scale(meta)


def test_goes_on_after_a_crash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`segment` names the frame that nobody expected, segments the ones after it, and exits with 1."""

    def broken(folder: Path, *_: object) -> tuple[int, str]:
        if folder.name == "bad":
            raise cv2.error("out of luck")
        return 3, ""

    monkeypatch.setattr(segment_frames, "segment_folder", broken)
    arguments = [str(tmp_path / name) for name in ("bad", "good")]
    assert segment_frames.main([*arguments, "--out", str(tmp_path / "out")]) == 1
    output = capsys.readouterr()
    assert "good: 3 objects" in output.out
    assert "1 of 2 frames failed: bad" in output.err
    assert (tmp_path / "out/bad/failed_frames/frame_1/error.txt").is_file()


@pytest.mark.parametrize("options", [["--region", "0", "1", "0", "1", "0", "1"], ["--noise", "3"]])
def test_options_that_make_no_sense(tmp_path: Path, options: list[str]) -> None:
    """A region without a pose and a noise that no camera has are refused."""
    with pytest.raises(SystemExit):
        segment_frames.main([str(tmp_path), "--out", str(tmp_path / "out"), *options])
