"""Clouds in files give the frames they were made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mbd_perception.cloud_files import load_cloud
from mbd_perception.frame import FrameError
from mbd_perception.scoring import score
from mbd_perception.segment_frames import main
from mbd_perception.segmentation import SegmentationConfig, segment
from mbd_perception.synthetic import Box, Cylinder, looking_at, render

VIEW = render(
    [
        Box((0.6, 0.15, 0.0), (0.08, 0.12, 0.1), (200, 40, 40), 0.3),
        Cylinder((0.7, -0.15, 0.0), 0.05, 0.1, (40, 40, 200)),
    ],
    looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05)),
    np.random.default_rng(0),
)


def points() -> np.ndarray:
    """(480, 640) structured points of the view, NaN where there is no depth."""
    columns, rows = VIEW.frame.camera.rays()
    z = np.where(VIEW.frame.depth > 0, VIEW.frame.depth, np.nan)
    made = np.zeros(z.shape, dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgb", "<u4")])
    made["x"], made["y"], made["z"] = columns * z, rows * z, z
    rgb = VIEW.frame.color.astype(np.uint32)
    made["rgb"] = rgb[..., 0] << 16 | rgb[..., 1] << 8 | rgb[..., 2]
    return made


def write_pcd(path: Path, cloud: np.ndarray, width: int, height: int, encoding: str = "binary") -> None:
    """A PCD file."""
    header = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
        f"WIDTH {width}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {width * height}\nDATA {encoding}\n"
    )
    rows = "\n".join(" ".join(str(v) for v in p) for p in cloud.ravel().tolist()).encode()
    path.write_bytes(header.encode() + (rows if encoding == "ascii" else cloud.tobytes()))


@pytest.mark.parametrize("encoding", ["binary", "ascii"])
def test_organized_pcd(tmp_path: Path, encoding: str) -> None:
    """An organized PCD is the frame it came from."""
    write_pcd(tmp_path / "a.pcd", points(), 640, 480, encoding)
    frame = load_cloud(tmp_path / "a.pcd")
    assert np.allclose(frame.depth, VIEW.frame.depth, atol=1e-5)
    assert np.array_equal(frame.color, VIEW.frame.color)
    assert frame.camera.fx == pytest.approx(525, rel=1e-3)


@pytest.mark.parametrize("kind", ["pcd", "ply"])
def test_loose_points(tmp_path: Path, kind: str) -> None:
    """Points in any order still show the two objects."""
    loose = np.random.default_rng(1).permutation(points()[VIEW.frame.depth > 0])
    path = tmp_path / f"loose.{kind}"
    if kind == "pcd":
        write_pcd(path, loose, len(loose), 1)
    else:
        dtype = [("x", ">f4"), ("y", ">f4"), ("z", ">f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
        made = np.zeros(len(loose), dtype=dtype)
        for name in "xyz":
            made[name] = loose[name]
        for shift, name in ((16, "red"), (8, "green"), (0, "blue")):
            made[name] = loose["rgb"] >> shift & 0xFF
        lines = [f"property float {n}" for n in "xyz"] + [f"property uchar {n}" for n in ("red", "green", "blue")]
        header = ["ply", "format binary_big_endian 1.0", f"element vertex {len(loose)}", *lines, "end_header", ""]
        path.write_bytes("\n".join(header).encode() + made.tobytes())
    frame = load_cloud(path)
    assert segment(frame, None, SegmentationConfig()).count == 2
    assert main([str(path), "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "loose" / "labels.png").is_file()


def test_bad_files(tmp_path: Path) -> None:
    """A file that is missing, cut off, compressed or no cloud is refused by name."""
    write_pcd(tmp_path / "whole.pcd", points(), 640, 480)
    content = (tmp_path / "whole.pcd").read_bytes()
    (tmp_path / "cut.pcd").write_bytes(content[:5000])
    (tmp_path / "squeezed.pcd").write_bytes(content.replace(b"DATA binary", b"DATA binary_compressed"))
    (tmp_path / "empty.ply").write_bytes(b"")
    (tmp_path / "other.txt").write_text("no cloud", encoding="utf-8")
    for name, words in (
        ("missing.pcd", "cannot be read"),
        ("cut.pcd", "holds"),
        ("squeezed.pcd", "uncompressed"),
        ("empty.ply", "not a whole .ply"),
        ("other.txt", "ends in .pcd or .ply"),
    ):
        with pytest.raises(FrameError, match=words) as caught:
            load_cloud(tmp_path / name)
        assert name in str(caught.value)


def test_truth(tmp_path: Path) -> None:
    """The segmentation of an organized cloud agrees with the truth."""
    write_pcd(tmp_path / "a.pcd", points(), 640, 480)
    found = segment(load_cloud(tmp_path / "a.pcd"), None, SegmentationConfig())
    result = score(found.labels, np.where(VIEW.labels > 1, VIEW.labels, 0), VIEW.frame.depth > 0)
    assert result.weighted_overlap > 0.95
