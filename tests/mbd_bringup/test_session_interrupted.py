"""``session`` answers Ctrl-C at once, at whatever moment it comes, and leaves no node behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from mbd_bringup.ros.live_session import install_prefixes

# The interpreter imports for seconds before the command's own code runs: interrupted there, at one of the last imports.
INTERRUPTED = """
import os, signal, sys
from mbd_bringup.session_command import main

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == "mbd_bringup.ros.next_offer":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
main()
"""


def test_interrupted_while_it_is_still_being_imported_it_says_so():
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "session: interrupted before anything was started\n")


def test_asked_to_end_twice_it_says_so_before_it_ends_its_nodes_and_leaves_none(tmp_path: Path, ros_domain: int):
    """The nodes are just starting: the hardest moment, as not all of them take notice of a signal yet."""
    program = install_prefixes(["mbd_bringup"])["mbd_bringup"] / "lib" / "mbd_bringup" / "session"
    words = [str(program), "--task", "sorting", "--participant", "p01", "--folder", str(tmp_path)]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(ros_domain)}
    session = subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert session.stdout is not None
    try:
        said = session.stdout.readline()
        assert "the nodes' output goes to" in said, said + session.stdout.read()
        assert list(nodes_in(tmp_path)), "no node was started: nothing is to be ended"
        for number in (signal.SIGINT, signal.SIGTERM):
            session.send_signal(number)
        said = session.stdout.read()
        assert session.wait(60) == 130, said
    finally:
        session.kill()
        session.wait()
    lines = [line for line in said.splitlines() if line]
    assert [line for line in lines if "interrupted" in line or "ending every node" in line] == [
        "ending every node and closing the bag, wait a moment",
        "interrupted: every node was ended; what was recorded is in the session's bag",
    ]
    assert list(nodes_in(tmp_path)) == []


def nodes_in(folder: Path) -> Iterator[str]:
    """Command lines of the processes that run with something of that folder."""
    for process in Path("/proc").glob("[0-9]*"):
        try:
            line = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue  # it has ended meanwhile
        if f"{folder}/" in line and int(process.name) != os.getpid():
            yield line
