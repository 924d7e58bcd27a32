"""Recording 640x480 RGB-D at 30 Hz, camera and recorder as processes of their own: nothing may be lost.

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
RATE, SECONDS = 30.0, 10.0
TOPICS = {
    "compressed": ("color/image_raw/compressed", "depth/image_raw/compressedDepth", "color/camera_info"),
    "raw": ("color/image_raw", "depth/image_raw", "color/camera_info"),
}


def recorded(folder: Path, images: str) -> tuple[int, list[int], float]:
    """Frames sent, messages recorded by topic, and the recorder's processor time [s]."""
    with private_domain() as domain:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        command = [str(RECORDER), "--ros-args", "-p", f"bag:={folder}", "-p", f"images:={images}"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        recorder = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        camera = subprocess.Popen(
            [sys.executable, str(CAMERA), str(RATE), str(SECONDS)], env=environment, stdout=subprocess.PIPE
        )
        output, _ = camera.communicate(timeout=60)
        usage_camera = _cpu(before)
        sent, took = int(output.split()[0]), float(output.split()[1])
        assert took < SECONDS + 1.0, f"the camera itself was too slow: {took:.1f} s"
        recorder.send_signal(signal.SIGINT)
        out, _ = recorder.communicate(timeout=30)
    assert recorder.returncode == 0, out
    counts = {t.name: t.count for t in Bag(folder).topics}
    return sent, [counts.get(f"/camera/{name}", 0) for name in TOPICS[images]], _cpu(before) - usage_camera


def _cpu(before: resource.struct_rusage) -> float:
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    return now.ru_utime + now.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.benchmark(group="recording 640x480 RGB-D at 30 Hz for 10 s")
@pytest.mark.parametrize("images", ["compressed", "raw"])
def test_rgbd_at_30_hz_is_recorded_without_a_loss(images: str, tmp_path: Path, benchmark: BenchmarkFixture):
    folder = tmp_path / "bag"
    begun = time.monotonic()
    sent, counts, cpu = benchmark.pedantic(recorded, (folder, images), rounds=1)
    size = sum(p.stat().st_size for p in folder.glob("*.mcap"))
    benchmark.extra_info |= {"sent": sent, "recorded": counts, "cpu_s": cpu, "MB": size / 1e6}
    print(
        f"\n{images:10}  sent {sent} frames, recorded {counts}; {size / 1e6 / SECONDS:5.1f} MB/s, "
        f"{100 * cpu / SECONDS:3.0f} % of one core, {time.monotonic() - begun:.0f} s in all"
    )
    assert counts == [sent] * 3
