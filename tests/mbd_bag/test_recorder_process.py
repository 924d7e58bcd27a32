"""The recorder as a process of its own, with real publishers around it."""

from __future__ import annotations

import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped
from mbd_bag.errors import BagError
from mbd_bag.recorder.topic_counts import stated_counts
from mbd_bag.session.session_facts import parameters_of
from mbd_bag.spool.reconciliation import GRACE
from mbd_bag.storage.bag import Bag
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs.msg import MappingEstimate, Prompt
from recorder_bench import Bench, arguments, notes, recorded
from rosbags.rosbag2 import Reader
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2

NONE = "lost 0, left out 0"


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    made = Bench(ros_domain)
    yield made
    made.close()


def test_a_recorder_asked_to_stop_closes_its_bag_and_states_what_is_in_it(bench: Bench, tmp_path: Path):
    latched = bench.node.create_publisher(Prompt, "interaction/prompt", LATCHED)
    latched.publish(Prompt(kind=Prompt.INFORM, text="output before the recorder came"))
    tool = bench.node.create_publisher(PoseStamped, "lab/tool_pose", SENSOR)
    bench.node.create_timer(0.05, lambda: tool.publish(PoseStamped()))
    bench.node.create_publisher(PointCloud2, "camera/points", SENSOR)
    # Somebody waits for it; whoever states it comes later than the recorder.
    bench.node.create_subscription(MappingEstimate, "mapping/estimate", lambda _: None, EVENTS)
    folder = tmp_path / "bag"
    process = bench.start(folder, "task:=sorting", "seed:=7", "participant:=p03")
    bench.spin_until_recorded()
    bench.spin_until_recorded("/mapping/estimate")
    late = bench.node.create_publisher(MappingEstimate, "mapping/estimate", LATCHED)
    late.publish(MappingEstimate())

    def enough() -> bool:
        try:
            found = Bag(folder)
        except BagError:
            return False
        count = {t.name: t.count for t in found.topics}
        known = "gain" in parameters_of(found.facts, "bench")
        wanted = {"/wizard/note": 81, "/lab/tool_pose": 21, "/mapping/estimate": 1, "/interaction/prompt": 1}
        return known and all(count.get(name, 0) >= number for name, number in wanted.items())

    bench.spin_until(enough, "all that is to be recorded")
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)  # a terminal's Ctrl-C reaches a node twice
    bench.spin_until(lambda: process.poll() is not None, "the recorder's end")
    output = process.communicate()[0]
    assert process.returncode == 0, output
    assert re.search(rf"recorder: \d+ messages on \d+ topics in {re.escape(str(folder))}", output)
    bag = Bag(folder)
    assert bag.problems == ()
    read = notes(folder)
    assert len(read) > 80
    assert read == list(range(read[0], read[0] + len(read)))
    counts = {t.name: t.count for t in bag.topics}
    assert counts["/lab/tool_pose"] > 20
    assert counts["/interaction/prompt"] == 1
    assert "/camera/points" not in counts
    assert "/rosout" in counts
    assert (bag.facts["task"], bag.facts["seed"], bag.facts["participant"]) == ("sorting", "7", "p03")
    assert bag.facts["session"] == "bag"
    assert bag.facts["version.mbd_study"]
    assert parameters_of(bag.facts, "bench")["gain"] == 2.5
    assert parameters_of(bag.facts, "bench")["camera"] == "/camera"
    # A bag does not reveal where on which machine it was recorded.
    assert parameters_of(bag.facts, "bench")["state_dir"] == Path(__file__).parent.name
    assert str(tmp_path) not in str(bag.facts)
    assert not any(str(p).encode() in m.data for m in bag.messages() for p in (tmp_path, Path(__file__).parent))
    # Nor does it leave out anything without saying so.
    assert stated_counts(bag.facts)["/wizard/note"].text() == f"received {len(read)}, written {len(read)}, {NONE}"
    with Reader(folder) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == counts
        offered = {c.topic: c.ext.offered_qos_profiles[0].durability.name for c in reader.connections if c.msgcount}
    assert offered["/interaction/prompt"] == offered["/mapping/estimate"] == "TRANSIENT_LOCAL"


@pytest.mark.alone
def test_a_killed_recorder_leaves_all_but_the_last_second_and_the_next_one_takes_the_rest_from_the_spool(
    bench: Bench, tmp_path: Path
):
    folder, spooled = tmp_path / "bag", ("run:='1a'", f"spool:={tmp_path / 'spool'}")
    bench.run("spool", "-p", f"folder:={tmp_path / 'spool'}", "-p", "run:='1a'")
    bench.spin_until_recorded(node="spool")
    first = bench.start(folder, *spooled)
    bench.spin_until(lambda: recorded(folder) > 20, "notes in the bag")
    bench.spin_for(1.0)
    first.kill()
    first.wait()
    killed_at = time.monotonic()
    read = notes(folder)
    latest = max(read)
    # What it got late, on a busy machine, it took from the spool, behind others; the last of that it still waited for.
    waited_for = set(range(min(read), latest)) - set(read)
    assert all(killed_at - bench.sent[k] < GRACE + 1.0 for k in waited_for)
    assert killed_at - bench.sent[latest] < 1.0
    assert len(read) > 30
    assert any("killed" in problem for problem in Bag(folder).problems)
    second = bench.start(folder, *spooled)
    # The middleware may hold a new reader's messages back for seconds while it still waits for the dead one.
    bench.spin_until(lambda: (folder / "bag_1.mcap").exists() and recorded(folder / "bag_1.mcap") > 20, "new notes")
    second.terminate()
    bench.spin_until(lambda: second.poll() is not None, "the recorder's end")
    assert second.returncode == 0, second.communicate()[0]
    kept = notes(folder)
    assert kept[: len(read)] == read
    # What was said while no recorder was there, the first not yet or the second not yet, is there all the same, once.
    assert sorted(kept) == list(range(min(kept), min(kept) + len(kept)))
    assert min(kept) < min(read)
    assert len(kept) > len(read) + 20
    with Reader(folder) as reader:
        assert [f["path"] for f in reader.storage.files] == ["bag_0.mcap", "bag_1.mcap"]
        assert len(list(reader.messages())) == reader.message_count


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        (["bag:=''"], "no bag to write"),
        (["exclude:=['(']"], "parameter exclude"),
        (["min_free:=900000000.0"], "MB are"),
    ],
)
def test_a_recorder_that_cannot_record_states_why(
    recorders: Any, ros_domain: int, tmp_path: Path, parameters: list[str], words: str
):
    process = recorders.start(ros_domain, "--ros-args", *arguments(tmp_path / "bag", *parameters))
    assert process.wait() == 1
    output = process.output()
    assert words in output
    assert "Traceback" not in output


def test_an_existing_bag_is_refused(recorders: Any, ros_domain: int, made_bag: Path):
    before = (made_bag / "made_0.mcap").read_bytes()
    process = recorders.start(ros_domain, "--ros-args", *arguments(made_bag))
    assert process.wait() == 1
    assert "never overwritten" in process.output()
    assert (made_bag / "made_0.mcap").read_bytes() == before


def test_a_recorder_started_again_within_its_session_goes_on_and_in_another_session_does_not(
    recorders: Any, bench: Bench, ros_domain: int, tmp_path: Path
):
    folder = tmp_path / "bag"

    def ended(run: str, number: int) -> Any:
        """A recorder of this start of a session, ended by one signal after 20 notes."""
        process = recorders.start(ros_domain, "--ros-args", *arguments(folder, f"run:='{run}'"))
        file = folder / f"bag_{number}.mcap"
        bench.spin_until(
            lambda: process.poll() is not None or (file.exists() and recorded(file) > 20), "notes in the bag"
        )
        process.send_signal(signal.SIGTERM if number else signal.SIGINT)
        return process

    assert ended("1a", 0).wait() == 0
    before = notes(folder)
    assert ended("1a", 1).wait() == 0
    assert notes(folder)[: len(before)] == before
    assert len(notes(folder)) > len(before) + 20
    other = ended("2b", 2)
    assert other.wait() == 1
    assert "never overwritten" in other.output()
    assert sorted(p.name for p in folder.iterdir()) == ["bag_0.mcap", "bag_1.mcap", "metadata.yaml"]


def test_a_recorder_that_gets_no_processor_time_for_seconds_loses_no_word(
    recorders: Any, bench: Bench, ros_domain: int, tmp_path: Path
):
    folder = tmp_path / "bag"
    process = recorders.start(ros_domain, "--ros-args", *arguments(folder))
    bench.spin_until(lambda: recorded(folder) > 20, "notes in the bag")
    process.send_signal(signal.SIGSTOP)
    before = len(bench.sent)
    bench.spin_until(lambda: len(bench.sent) > before + 100, "notes while it is stopped")
    process.send_signal(signal.SIGCONT)
    bench.spin_until(lambda: notes(folder)[-1] > before + 100, "notes afterwards")
    process.send_signal(signal.SIGINT)
    assert process.wait() == 0
    read = notes(folder)
    assert read == list(range(read[0], read[0] + len(read)))
    assert stated_counts(Bag(folder).facts)["/wizard/note"].missing == 0


def test_with_simulated_time_a_bag_is_stamped_by_the_clock_topic(bench: Bench, tmp_path: Path):
    clock = bench.node.create_publisher(Clock, "/clock", SENSOR)
    now = 0.0

    def tick() -> None:
        nonlocal now
        now += 0.5
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(now), int((now % 1.0) * 1e9)
        clock.publish(message)

    process = bench.start(tmp_path / "bag", "use_sim_time:=true")
    bench.spin_until_recorded()
    bench.spin_for(0.5)
    bench.node.create_timer(0.05, tick)

    def late() -> bool:
        try:
            return Bag(tmp_path / "bag").end > 5e9
        except BagError:
            return False

    bench.spin_until(late, "messages stamped by the clock")
    process.send_signal(signal.SIGINT)
    bench.spin_until(lambda: process.poll() is not None, "the recorder's end")
    assert process.returncode == 0
    bag = Bag(tmp_path / "bag")
    stamps = [x.log_time for x in bag.files[0].messages()]
    assert stamps == sorted(stamps)
    assert stamps[0] > 0  # what came before the first /clock is not of 1970
    assert 5e9 < bag.end <= now * 1e9
