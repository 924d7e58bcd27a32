"""The segment command, on frames written to files."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from mbd_perception.synthetic.render import KINECT, Box, Cylinder, looking_at, render
from mbd_perception.tools.segment_frames import main

POSE = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))


def write_frame(folder: Path, solids: list[Box | Cylinder]) -> np.ndarray:
    """Write a synthetic frame; its true labels."""
    folder.mkdir()
    view = render(solids, POSE, np.random.default_rng(0))
    cv2.imwrite(str(folder / "color.png"), np.ascontiguousarray(view.frame.color[..., ::-1]))
    cv2.imwrite(str(folder / "depth.png"), np.rint(view.frame.depth * 1000).astype(np.uint16))
    camera = {k: getattr(KINECT, k) for k in ("fx", "fy", "cx", "cy", "width", "height")}
    (folder / "meta.json").write_text(json.dumps({"camera": camera}), encoding="utf-8")
    return view.labels


def test_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each frame gets labels.png, objects.json and an overlay that agree with each other and with the truth."""
    solids: list[Box | Cylinder] = [
        Box((0.6, 0.2, 0.0), (0.08, 0.08, 0.08), (200, 40, 40)),
        Cylinder((0.7, -0.1, 0.0), 0.04, 0.1, (40, 40, 200)),
    ]
    truth = write_frame(tmp_path / "one", solids)
    write_frame(tmp_path / "bare", [])
    assert main([str(tmp_path / "one"), str(tmp_path / "bare"), "--out", str(tmp_path / "out")]) == 0
    assert "one: 2 objects" in capsys.readouterr().out
    labels = cv2.imread(str(tmp_path / "out/one/labels.png"), cv2.IMREAD_UNCHANGED)
    document = json.loads((tmp_path / "out/one/objects.json").read_text(encoding="utf-8"))
    assert labels.shape == truth.shape
    assert sorted(o["label"] for o in document["objects"]) == [1, 2]
    for obj in document["objects"]:
        assert (labels == obj["label"]).sum() == obj["pixels"]
        z = obj["centroid_cam_m"][2]
        u = round(KINECT.cx + KINECT.fx * obj["centroid_cam_m"][0] / z)
        v = round(KINECT.cy + KINECT.fy * obj["centroid_cam_m"][1] / z)
        assert labels[v, u] == obj["label"]
    assert {o["color"] for o in document["objects"]} == {"red", "blue"}
    assert cv2.imread(str(tmp_path / "out/one/overlay.png")).shape == (480, 640, 3)
    assert not cv2.imread(str(tmp_path / "out/bare/labels.png"), cv2.IMREAD_UNCHANGED).any()
    assert json.loads((tmp_path / "out/bare/objects.json").read_text(encoding="utf-8"))["objects"] == []


def test_bad_frames(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A frame that cannot be used is named with the reason, the others are still done, and the exit code reports it."""
    write_frame(tmp_path / "good", [Box((0.6, 0.2, 0.0), (0.08, 0.08, 0.08), (200, 40, 40))])
    write_frame(tmp_path / "no_meta", [])
    (tmp_path / "no_meta/meta.json").unlink()
    write_frame(tmp_path / "no_key", [])
    (tmp_path / "no_key/meta.json").write_text('{"camera": {"fx": 1}}', encoding="utf-8")
    write_frame(tmp_path / "broken", [])
    (tmp_path / "broken/depth.png").write_text("no picture", encoding="utf-8")
    write_frame(tmp_path / "eight_bit", [])
    cv2.imwrite(str(tmp_path / "eight_bit/depth.png"), np.ones((480, 640), dtype=np.uint8))
    names = ("no_meta", "no_key", "broken", "eight_bit", "absent", "good")
    assert main([*(str(tmp_path / n) for n in names), "--out", str(tmp_path / "out")]) == 1
    output = capsys.readouterr()
    assert "good: 1 objects" in output.out
    for name, words in (
        ("no_meta", "meta.json"),
        ("no_key", "camera.'fy' is missing"),
        ("broken", "no picture"),
        ("eight_bit", "expected uint16"),
        ("absent", "is missing"),
    ):
        assert any(line.startswith(f"{name}: ") and words in line for line in output.err.splitlines()), output.err


def test_same_names(tmp_path: Path) -> None:
    """Frames of the same name would overwrite each other: refused."""
    with pytest.raises(SystemExit):
        main([str(tmp_path / "a/x"), str(tmp_path / "b/x"), "--out", str(tmp_path)])


@pytest.mark.parametrize(
    ("meta", "words"),
    [
        ("[1, 2]", "expected {"),
        ("7", "expected {"),
        ('{"camera": [1]}', "expected {"),
        ('{"camera": {"fx": 1e999, "fy": 1, "cx": 1, "cy": 1, "width": 640, "height": 480}}', "camera.fx is 'inf'"),
        ('{"camera": {"fx": 1, "fy": 1, "cx": [1], "cy": 1, "width": 640, "height": 480}}', "camera.cx is '[1]'"),
        ('{"camera": {"fx": 1, "fy": 1, "cx": 1, "cy": 1, "width": 1e999, "height": 480}}', "camera.width is 'inf'"),
        ('{"camera": {"fx": 0, "fy": 1, "cx": 1, "cy": 1, "width": 640, "height": 480}}', "must be positive"),
        ('{"camera": ', "is no JSON in UTF-8"),
    ],
)
def test_any_meta(tmp_path: Path, capsys: pytest.CaptureFixture[str], meta: str, words: str) -> None:
    """Whatever meta.json holds, one sentence names the file, and nothing of an earlier run is left as the result."""
    write_frame(tmp_path / "frame", [])
    (tmp_path / "frame/meta.json").write_text(meta, encoding="utf-8")
    earlier = tmp_path / "out/frame"
    earlier.mkdir(parents=True)
    (earlier / "labels.png").write_bytes(b"old")
    (earlier / "objects.json").write_text("{}", encoding="utf-8")
    assert main([str(tmp_path / "frame"), "--out", str(tmp_path / "out")]) == 1
    first, _ = capsys.readouterr().err.splitlines()
    assert first.startswith("frame: ")
    assert "meta.json" in first
    assert words in first
    assert list(earlier.iterdir()) == []


def test_byte_order_mark(tmp_path: Path) -> None:
    """A meta.json as editors of some systems write it is read."""
    write_frame(tmp_path / "frame", [Box((0.6, 0.2, 0.0), (0.08, 0.08, 0.08), (200, 40, 40))])
    meta = tmp_path / "frame/meta.json"
    meta.write_text(meta.read_text(encoding="utf-8"), encoding="utf-8-sig")
    assert main([str(tmp_path / "frame"), "--out", str(tmp_path / "out")]) == 0


def test_out_is_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where nothing can be written nothing is computed, and that is said."""
    (tmp_path / "out").write_text("", encoding="utf-8")
    with pytest.raises(SystemExit):
        main([str(tmp_path / "frame"), "--out", str(tmp_path / "out")])
    assert "cannot be written to" in capsys.readouterr().err
