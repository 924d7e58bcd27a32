"""Clouds in files give the frames they were made of."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import open3d
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mbd_model.camera.intrinsics import Intrinsics
from mbd_perception.frames.cloud_files import load_cloud
from mbd_perception.frames.frame import FrameError
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render
from mbd_perception.synthetic.scoring import score
from mbd_perception.tools.segment_frames import main

WIDTH, HEIGHT = 320, 240
SMALL = Intrinsics(fx=262.5, fy=262.5, cx=159.5, cy=119.5, width=WIDTH, height=HEIGHT)
VIEW = render(
    [
        Box((0.6, 0.15, 0.0), (0.08, 0.12, 0.1), (200, 40, 40), 0.3),
        Cylinder((0.7, -0.15, 0.0), 0.05, 0.1, (40, 40, 200)),
    ],
    looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05)),
    np.random.default_rng(0),
    camera=SMALL,
)


def points() -> np.ndarray:
    """(HEIGHT, WIDTH) structured points of the view, NaN where there is no depth."""
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
    write_pcd(tmp_path / "a.pcd", points(), WIDTH, HEIGHT, encoding)
    frame = load_cloud(tmp_path / "a.pcd")
    assert np.allclose(frame.depth, VIEW.frame.depth, atol=1e-5)
    assert np.array_equal(frame.color, VIEW.frame.color)
    assert frame.camera.fx == pytest.approx(SMALL.fx, rel=1e-3)


def write_compressed(path: Path, width: int, height: int) -> None:
    """The view as a compressed PCD, as PCL writes it."""
    cloud = open3d.t.geometry.PointCloud()
    made = points().ravel()
    cloud.point.positions = open3d.core.Tensor(np.stack([made[n] for n in "xyz"], axis=-1))
    cloud.point.colors = open3d.core.Tensor(VIEW.frame.color.reshape(-1, 3).copy())
    assert open3d.t.io.write_point_cloud(path, cloud, compressed=True)
    row, rows = f"WIDTH {width * height}\nHEIGHT 1\n".encode(), f"WIDTH {width}\nHEIGHT {height}\n".encode()
    content = path.read_bytes()
    assert row in content
    assert b"DATA binary_compressed" in content
    path.write_bytes(content.replace(row, rows))


def test_compressed_pcd(tmp_path: Path) -> None:
    """A compressed, organized PCD is the frame it came from."""
    write_compressed(tmp_path / "a.pcd", WIDTH, HEIGHT)
    frame = load_cloud(tmp_path / "a.pcd")
    assert np.allclose(frame.depth, VIEW.frame.depth, atol=1e-5)
    assert np.array_equal(frame.color, VIEW.frame.color)


@pytest.mark.parametrize(("old", "new"), [(b"FIELDS x y z rgb", b"FIELDS x y z rgba"), (b"F F F U", b"F F F F")])
def test_packed_colors(tmp_path: Path, old: bytes, new: bytes) -> None:
    """Packed colour is read whether it is called rgb or rgba, integer or float."""
    write_pcd(tmp_path / "a.pcd", points(), WIDTH, HEIGHT)
    (tmp_path / "a.pcd").write_bytes((tmp_path / "a.pcd").read_bytes().replace(old, new))
    assert np.array_equal(load_cloud(tmp_path / "a.pcd").color, VIEW.frame.color)


def test_colorless(tmp_path: Path) -> None:
    """A cloud without colour is grey."""
    loose = points()[VIEW.frame.depth > 0]
    rows = "\n".join(f"{p['x']} {p['y']} {p['z']}" for p in loose)
    properties = "".join(f"property float {n}\n" for n in "xyz")
    header = f"ply\nformat ascii 1.0\nelement vertex {len(loose)}\n{properties}end_header\n"
    (tmp_path / "a.ply").write_text(header + rows + "\n", encoding="ascii")
    frame = load_cloud(tmp_path / "a.ply")
    assert (frame.color == 128).all()
    assert segment(frame, None, SegmentationConfig()).count == 2


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
    """A file that is missing, cut off, damaged or no cloud is refused by name."""
    write_pcd(tmp_path / "complete.pcd", points(), WIDTH, HEIGHT)
    content = (tmp_path / "complete.pcd").read_bytes()
    (tmp_path / "cut.pcd").write_bytes(content[:5000])
    (tmp_path / "squeezed.pcd").write_bytes(content.replace(b"DATA binary", b"DATA binary_compressed"))
    (tmp_path / "lying.pcd").write_bytes(content.replace(b"WIDTH 320", b"WIDTH 4000000"))
    (tmp_path / "bare.pcd").write_bytes(content.replace(b"HEIGHT 240", b"HEIGHT 0"))
    (tmp_path / "empty.ply").write_bytes(b"")
    (tmp_path / "other.txt").write_text("no cloud", encoding="utf-8")
    for name, words in (
        ("missing.pcd", "cannot be read"),
        ("cut.pcd", "holds"),
        ("squeezed.pcd", "can be read"),
        ("lying.pcd", "states 960000000 points but it holds"),
        ("bare.pcd", "write it again"),
        ("empty.ply", "not a complete .ply"),
        ("other.txt", "ends in .pcd or .ply"),
    ):
        with pytest.raises(FrameError, match=words) as caught:
            load_cloud(tmp_path / name)
        assert name in str(caught.value)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(["binary", "ascii", "ply"]), st.floats(0.0, 0.99), st.booleans())
def test_cut_off(tmp_path: Path, encoding: str, share: float, in_header: bool) -> None:
    """Wherever a file ends too early, it is refused."""
    part = points()[100:, 160:170].copy()
    path = tmp_path / ("a.ply" if encoding == "ply" else "a.pcd")
    if encoding == "ply":
        cloud = open3d.t.geometry.PointCloud(np.stack([part[n].ravel() for n in "xyz"], axis=-1))
        assert open3d.t.io.write_point_cloud(path, cloud)
    else:
        write_pcd(path, part, 10, len(part), encoding)
    content = path.read_bytes()
    size = content.index(b"end_header" if encoding == "ply" else b"DATA") if in_header else len(content)
    path.write_bytes(content[: int(share * size)])
    with pytest.raises(FrameError, match=r"write it again|but it holds"):
        load_cloud(path)


def test_last_row(tmp_path: Path) -> None:
    """A file of text whose last point lacks its last number is refused."""
    part = points()[100:110, 160:170].copy()
    path = tmp_path / "a.pcd"
    write_pcd(path, part, 10, len(part), "ascii")
    assert load_cloud(path).depth.shape == part.shape
    path.write_bytes(path.read_bytes().rpartition(b" ")[0])
    with pytest.raises(FrameError, match=r"write it again"):
        load_cloud(path)


def test_truth(tmp_path: Path) -> None:
    """The segmentation of an organized cloud agrees with the truth."""
    write_pcd(tmp_path / "a.pcd", points(), WIDTH, HEIGHT)
    found = segment(load_cloud(tmp_path / "a.pcd"), None, SegmentationConfig())
    result = score(found.labels, np.where(VIEW.labels > 1, VIEW.labels, 0), VIEW.frame.depth > 0)
    assert result.weighted_overlap > 0.95


def test_open3d_stays_out_of_the_node() -> None:
    """Neither the node nor the command loads Open3D before a cloud is read: it takes a second."""
    code = "import sys, mbd_perception.ros.node, mbd_perception.tools.segment_frames; sys.exit('open3d' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
