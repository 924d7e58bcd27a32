"""The options of the segment command, and what it says beside the number of objects."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mbd_model.camera.pose import CameraPose
from mbd_perception.frames.evidence import save_frame
from mbd_perception.synthetic.render import Box, Cylinder, Table, looking_at, render
from mbd_perception.synthetic.sensors import Sensor
from mbd_perception.tools.segment_frames import main
from scipy.spatial.transform import Rotation

POSE = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))
SOLIDS: list[Box | Cylinder] = [
    Box((0.6, 0.2, 0.0), (0.08, 0.1, 0.08), (200, 40, 40)),
    Cylinder((0.7, -0.15, 0.0), 0.04, 0.1, (40, 40, 200)),
]


def written(folder: Path, noise: float = 1.5e-3, table: Table | None = None, clutter: tuple[Box, ...] = ()) -> Path:
    """A frame folder of two things on a table."""
    folder.mkdir()
    rng = np.random.default_rng(0)
    view = render(SOLIDS, POSE, rng, table=table, clutter=clutter, sensor=Sensor(noise=noise))
    save_frame(folder, view.frame)
    return folder


def pose_words(pose: CameraPose) -> list[str]:
    """A pose as --pose takes it."""
    return ["--pose", *(f"{v:.9f}" for v in (*pose.position, *Rotation.from_matrix(pose.rotation).as_quat()))]


def result(folder: Path) -> Any:
    """What objects.json holds."""
    return json.loads((folder / "objects.json").read_text(encoding="utf-8"))


def test_pose(tmp_path: Path) -> None:
    """With a pose the objects are in the base frame, where they were put; without, in a frame on the table."""
    frame = written(tmp_path / "frame")
    assert main([str(frame), "--out", str(tmp_path / "known"), *pose_words(POSE)]) == 0
    found = result(tmp_path / "known/frame")
    assert found["frame"] == "j2n6s300_link_base"
    places = {o["color"]: o["centroid_m"][:2] for o in found["objects"]}
    assert places["red"] == pytest.approx([0.6, 0.2], abs=0.03)
    assert places["blue"] == pytest.approx([0.7, -0.15], abs=0.03)
    assert main([str(frame), "--out", str(tmp_path / "open")]) == 0
    assert result(tmp_path / "open/frame")["frame"].startswith("table: z up")


def test_region(tmp_path: Path) -> None:
    """What lies outside the region is no object."""
    frame = written(tmp_path / "frame")
    options = [*pose_words(POSE), "--region", "0.3", "1.2", "0.0", "0.6", "-0.05", "0.5"]
    assert main([str(frame), "--out", str(tmp_path / "out"), *options]) == 0
    assert [o["color"] for o in result(tmp_path / "out/frame")["objects"]] == ["red"]


@pytest.mark.parametrize("options", [[], ["--noise", "7.4e-3"]])
def test_noise(tmp_path: Path, options: list[str]) -> None:
    """A noise of 6 mm at 0.9 m, given or not, is measured and stated."""
    frame = written(tmp_path / "frame", noise=7.4e-3)
    assert main([str(frame), "--out", str(tmp_path / "out"), *options]) == 0
    found = result(tmp_path / "out/frame")
    assert len(found["objects"]) == 2
    assert found["table"]["depth_noise_per_m"] == pytest.approx(7.4e-3, rel=0.15)


@pytest.mark.parametrize(("scale", "words"), [(5, "5 times those of a RealSense"), (10, "10 times too large")])
def test_units(tmp_path: Path, capsys: pytest.CaptureFixture[str], scale: int, words: str) -> None:
    """Depth in other units is pointed out, and right with depth_scale in meta.json."""
    frame = written(tmp_path / "frame")
    depth: Any = cv2.imread(str(frame / "depth.png"), cv2.IMREAD_UNCHANGED)
    cv2.imwrite(str(frame / "depth.png"), np.minimum(depth.astype(np.int64) * scale, 65534).astype(np.uint16))
    main([str(frame), "--out", str(tmp_path / "wrong")])
    output = capsys.readouterr()
    assert words in output.out + output.err
    meta = json.loads((frame / "meta.json").read_text(encoding="utf-8"))
    meta["camera"]["depth_scale"] = 0.001 / scale
    (frame / "meta.json").write_text(json.dumps(meta), encoding="utf-8")
    assert main([str(frame), "--out", str(tmp_path / "right")]) == 0
    assert "depth units" not in capsys.readouterr().out
    found = result(tmp_path / "right/frame")
    assert found["table"]["camera_height_m"] == pytest.approx(0.7, abs=0.01)
    assert len(found["objects"]) == 2


def test_other_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A second table is said, with its height, and kept in objects.json."""
    table = Table(x=(0.35, 1.2), y=(-0.3, 0.6), floor_z=-0.72)
    bench = Box((0.9, -0.75, -0.25), (0.9, 0.7, 0.05), (190, 188, 185))
    frame = written(tmp_path / "frame", table=table, clutter=(bench,))
    assert main([str(frame), "--out", str(tmp_path / "out")]) == 0
    assert "another table is in view (to the right, 0.2" in capsys.readouterr().out
    (other,) = result(tmp_path / "out/frame")["other_tables"]
    assert other["higher_m"] == pytest.approx(-0.2, abs=0.02)


def test_wrong_pose(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A quaternion of length 0 is a wrong call."""
    with pytest.raises(SystemExit) as raised:
        main([str(tmp_path), "--out", str(tmp_path / "out"), "--pose", *"0000000"])
    assert raised.value.code == 2
    assert "length 0" in capsys.readouterr().err


@pytest.mark.parametrize("factor", [5.0, 0.2])
def test_units_by_the_pose(tmp_path: Path, capsys: pytest.CaptureFixture[str], factor: float) -> None:
    """A camera 0.55 m above the table, whose depths say 2.75 or 0.11 m, is told by its pose."""
    pose = looking_at((0.2, 0.0, 0.55), (0.65, 0.0, 0.0))
    view = render([Box((0.6, 0.1, 0.0), (0.1, 0.1, 0.1), (200, 40, 40))], pose, np.random.default_rng(0))
    (tmp_path / "frame").mkdir()
    save_frame(tmp_path / "frame", replace(view.frame, depth=view.frame.depth * np.float32(factor)))
    main([str(tmp_path / "frame"), "--out", str(tmp_path / "out"), *pose_words(pose)])
    output = capsys.readouterr()
    assert "are the depth units right?" in output.out + output.err
