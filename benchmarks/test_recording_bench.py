"""Recording 640x480 RGB-D, of one camera at 30 Hz and of two at 15 Hz, each a process of its own: nothing may be lost.

Ten seconds of it show how much processor time and disk a second of recording costs, compressed and raw.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_prefix
from mbd_bag.storage.bag import Bag
from mbd_bringup.domain import private_domain
from pytest_benchmark.fixture import BenchmarkFixture

RECORDER = Path(get_package_prefix("mbd_bag")) / "lib" / "mbd_bag" / "recorder"
CAMERA = Path(__file__).with_name("rgbd_publisher.py")
SECONDS = 10.0
RIGS = {"one at 30 Hz": (("camera",), 30.0), "two at 15 Hz": (("camera", "camera_2"), 15.0)}
TOPICS = {
    "compressed": ("color/image_raw/compressed", "depth/image_raw/compressedDepth", "color/camera_info"),
    "raw": ("color/image_raw", "depth/image_raw", "color/camera_info"),
}


def recorded(folder: Path, images: str, cameras: tuple[str, ...], rate: float) -> tuple[list[int], list[int], float]:
    """Frames sent and messages recorded, of each topic of each camera, and the recorder's processor time [s]."""
    with private_domain() as domain:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        command = [str(RECORDER), "--ros-args", "-p", f"bag:={folder}", "-p", f"images:={images}"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        recorder = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        started = [
            subprocess.Popen(
                [sys.executable, str(CAMERA), str(rate), str(SECONDS), name], env=environment, stdout=subprocess.PIPE
            )
            for name in cameras
        ]
        sent = []
        for camera in started:
            output, _ = camera.communicate(timeout=60)
            sent += [int(output.split()[0])] * 3
            took = float(output.split()[1])
            assert took < SECONDS + 1.0, f"a camera itself was too slow: {took:.1f} s"
        usage_camera = _cpu(before)
        recorder.send_signal(signal.SIGINT)
        out, _ = recorder.communicate(timeout=30)
    assert recorder.returncode == 0, out
    counts = {t.name: t.count for t in Bag(folder).topics}
    arrived = [counts.get(f"/{camera}/{name}", 0) for camera in cameras for name in TOPICS[images]]
    return sent, arrived, _cpu(before) - usage_camera


def _cpu(before: resource.struct_rusage) -> float:
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    return now.ru_utime + now.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.benchmark(group="recording 640x480 RGB-D for 10 s")
@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("images", ["compressed", "raw"])
def test_rgbd_is_recorded_without_a_loss(rig: str, images: str, tmp_path: Path, benchmark: BenchmarkFixture):
    folder = tmp_path / "bag"
    begun = time.monotonic()
    sent, counts, cpu = benchmark.pedantic(recorded, (folder, images, *RIGS[rig]), rounds=1)
    size = sum(p.stat().st_size for p in folder.glob("*.mcap"))
    benchmark.extra_info |= {"sent": sent, "recorded": counts, "cpu_s": cpu, "MB": size / 1e6}
    print(
        f"\n{rig}, {images:10}  sent {sent} frames, recorded {counts}; {size / 1e6 / SECONDS:5.1f} MB/s, "
        f"{100 * cpu / SECONDS:3.0f} % of one core, {time.monotonic() - begun:.0f} s in all"
    )
    assert counts == sent
