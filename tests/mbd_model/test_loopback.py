"""A node waits for this machine's own address before it joins the others, and says when it does not come."""

from __future__ import annotations

import subprocess
import sys

import pytest
from mbd_model.ros.command_line import wait_for_loopback

WAITING = "from mbd_model.ros.command_line import wait_for_loopback; wait_for_loopback({})"


def in_a_network_of_its_own(script: str, patience: float) -> subprocess.CompletedProcess[str]:
    """Wait in a new network namespace, whose loopback device is down, while a shell does something there."""
    command = ["unshare", "-n", "sh", "-c", script, "sh", sys.executable, "-c", WAITING.format(patience)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "unshare failed" in done.stderr:
        pytest.skip("no network namespace can be made here: that takes root")
    return done


def test_where_the_address_is_there_nothing_is_waited_for():
    wait_for_loopback(0.0)


def test_a_loopback_device_that_comes_up_is_waited_for():
    done = in_a_network_of_its_own('"$@" & ip link set lo up; wait $!', 60.0)
    assert done.returncode == 0, done.stderr


def test_one_that_stays_down_is_named_with_what_to_do():
    done = in_a_network_of_its_own('"$@"', 0.1)
    assert done.returncode == 1
    assert "127.0.0.1 is not there (Network is unreachable): bring the loopback device up" in done.stderr
