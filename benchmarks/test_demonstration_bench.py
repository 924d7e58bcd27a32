"""What a demonstration recorded at 1 kHz costs its node, alive: tool poses and joint states of another process.

``MBD_BENCH_SECONDS=600`` records ten minutes; by default it is twenty seconds.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_prefix
from mbd_bringup.domain import private_domain
from pytest_benchmark.fixture import BenchmarkFixture

NODE = Path(get_package_prefix("mbd_demonstration")) / "lib" / "mbd_demonstration" / "demonstration"
ARM = Path(__file__).with_name("arm_publisher.py")
RATE, SECONDS = 1000.0, float(os.environ.get("MBD_BENCH_SECONDS", "20"))


def cpu(process: int) -> float:
    """Processor time of a process so far [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def recorded(state_dir: Path) -> tuple[float, float]:
    """(seconds recorded, processor time that the node took for them [s])."""
    with private_domain() as domain:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        options = ["-p", "gripper_source:=joint", "-p", f"state_dir:={state_dir}"]
        node = subprocess.Popen([str(NODE), "--ros-args", *options], env=environment)
        try:
            arm = subprocess.Popen(
                [sys.executable, str(ARM), str(RATE), str(SECONDS)], env=environment, stdout=subprocess.PIPE, text=True
            )
            assert arm.stdout is not None
            assert arm.stdout.readline() == "begun\n"
            before = cpu(node.pid)
            took = float(arm.stdout.readline().split()[1])
            used = cpu(node.pid) - before
            arm.wait(timeout=30)
        finally:
            node.send_signal(signal.SIGINT)
            node.wait(timeout=30)
    return took, used


@pytest.mark.timeout(SECONDS + 120.0)
@pytest.mark.benchmark(group="a demonstration recorded at 1 kHz")
def test_recording_at_1_khz(tmp_path: Path, benchmark: BenchmarkFixture):
    took, used = benchmark.pedantic(recorded, (tmp_path,), rounds=1)
    benchmark.extra_info |= {"seconds": took, "cpu_s": used}
    print(f"\n{took:.0f} s of {RATE:.0f} Hz poses and joint states: {100 * used / took:.1f} % of one core")
    assert took < 1.5 * SECONDS, "the robot process itself was too slow"
