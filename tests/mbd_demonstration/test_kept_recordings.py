"""What was recorded outlives the node that recorded it."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path

from demonstration_session import Session, steps_of
from mbd_demonstration.journal import found
from mbd_demonstration.recording import Recording
from mbd_demonstration.synthetic import Demonstration
from mbd_model.ros.conversions import time_from_msg, time_to_msg
from mbd_msgs.srv import ReviseTask


def test_a_node_that_comes_back_publishes_its_task_again(ros_domain: int, tmp_path: Path, shown: Demonstration):
    first = Session(ros_domain, tmp_path)
    first.observe(shown)
    first.ask("start")
    first.play(shown)
    first.ask("stop")
    first.close()
    again = Session(ros_domain, tmp_path)
    again.until(lambda: len(again.tasks) > 0)
    assert steps_of(again.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    again.close()


def test_a_recording_whose_node_died_goes_on_where_it_was(ros_domain: int, tmp_path: Path, shown: Demonstration):
    """Nothing is asked of the first node as it ends, as with kill -9: what counts is what was on disk before."""
    half = shown.events[1].stamp + 1.5
    parts = [
        dataclasses.replace(
            shown,
            **{k: getattr(shown, k)[chosen] for k in ("stamps", "positions", "quaternions", "joint")},
            events=tuple(e for e in shown.events if (e.stamp <= half) == first),
        )
        for first, chosen in ((True, shown.stamps <= half), (False, shown.stamps > half))
    ]
    one = Session(ros_domain, tmp_path)
    one.observe(shown)
    one.ask("start")
    one.play(parts[0])
    last = time.monotonic()
    file = tmp_path / "demonstration.recording"
    rows = len(one.node.recording.poses)

    def on_disk() -> bool:
        cut = found(file)
        recording = cut.into(Recording(shown.scene, 0.0)) if cut else None
        return recording is not None and len(recording.poses) == rows and len(recording.events) == 2

    one.until(on_disk)
    assert time.monotonic() - last < 2.0  # written each half second; the rest is this machine's
    one.close()
    other = Session(ros_domain, tmp_path)
    other.until(lambda: other.node.recording is not None and len(other.node.recording.poses) == rows)
    for event in parts[1].events:
        other.node.recording.add_event(event)
    other.play(dataclasses.replace(parts[1], events=()), words=False)
    assert other.ask("stop").success
    other.until(lambda: len(other.tasks) > 0)
    assert steps_of(other.tasks[-1]) == [(int(k), i) for k, i in shown.steps]
    assert not file.exists()
    other.close()


def test_a_step_is_split_also_by_a_node_that_came_back_after_the_demonstration(
    ros_domain: int, tmp_path: Path, shown: Demonstration
):
    """Where the tool was on the way is kept beside the task."""
    one = Session(ros_domain, tmp_path)
    one.show(shown)
    one.close()
    other = Session(ros_domain, tmp_path)
    other.until(lambda: bool(other.tasks))
    pick, place = (time_from_msg(other.tasks[-1].steps[k].end) for k in (0, 1))
    answer = other.revise(change=ReviseTask.Request.SPLIT, step=1, at=time_to_msg((pick + place) / 2))
    assert answer.success, answer.message
    other.until(lambda: len(other.tasks[-1].steps) == len(shown.steps) + 2)
    other.close()
