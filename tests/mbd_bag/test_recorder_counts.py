"""A recorder tells what it misses, keeps within its memory, and states no folder of the machine."""

from __future__ import annotations

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.recorder.held_messages import HeldMessages
from mbd_bag.recorder.memory_budget import MemoryBudget
from mbd_bag.recorder.topic_counts import TopicCount, count_facts, stated_counts
from mbd_bag.ros.host_free_messages import LOG, PARAMETER_EVENT, host_free_bytes, host_free_text
from rcl_interfaces.msg import Log, Parameter, ParameterEvent, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message


@given(sent=st.integers(1, 200), arrived=st.sets(st.integers(0, 199), min_size=2))
def test_every_message_between_the_first_and_the_last_that_arrived_is_received_or_lost(sent: int, arrived: set[int]):
    count = TopicCount()
    for number in sorted(arrived):
        count.receive(number, alone=True)
    assert count.received == len(arrived)
    assert count.received + count.lost == max(arrived) - min(arrived) + 1


@given(numbers=st.lists(st.integers(0, 10**12), max_size=50))
def test_nothing_counts_as_lost_while_several_publish(numbers: list[int]):
    count = TopicCount()
    for number in numbers:
        count.receive(number, alone=False)
    assert (count.received, count.lost) == (len(numbers), 0)


def test_another_publisher_is_no_loss():
    count = TopicCount()
    for number in (5, 6, 1, 2, 2**40, 2**40 + 1):
        count.receive(number, alone=True)
    assert count.lost == 0


@given(st.dictionaries(st.from_regex(r"/[a-z]{1,8}", fullmatch=True), st.tuples(*[st.integers(0, 10**9)] * 4)))
def test_what_a_bag_states_of_its_counts_is_read_back(counts: dict[str, tuple[int, int, int, int]]):
    known = {topic: TopicCount(*numbers) for topic, numbers in counts.items() if numbers[0]}
    assert stated_counts({**count_facts(known), "session": "s", "counts./X": "received ²"}) == known


@given(shares=st.lists(st.floats(0.0, 1.5), min_size=1, max_size=40))
def test_the_fuller_the_memory_the_fewer_pictures_are_kept_and_beyond_it_none(shares: list[float]):
    def kept(share: float) -> int:
        budget = MemoryBudget(1000)
        budget.take(int(share * 1000))
        return sum(budget.keeps(number) for number in range(80))

    rates = [kept(share) for share in sorted(shares)]
    assert rates == sorted(rates, reverse=True)
    assert kept(0.4) == 80
    assert kept(1.0) == 0


def test_what_is_held_is_written_in_order_and_only_pictures_are_left_out():
    held, written = HeldMessages(), []
    large = 40 << 20
    for number, picture in enumerate((True, True, False, True)):
        assert held.hold(lambda n=number: written.append(n), large, picture=picture) == (number in (0, 2))
    held.release()
    assert written == [0, 2]
    assert not held


def test_a_log_states_file_names_without_their_folders_and_topics_as_they_are(tmp_path: Path):
    text = f"restored /camera/color from {tmp_path}/state/scene.cdr, see http://lab:8080/observe"
    assert host_free_text(text) == "restored /camera/color from scene.cdr, see http://lab:8080/observe"
    log = Log(msg=text, file=f"{tmp_path}/node.py")
    free = deserialize_message(host_free_bytes(serialize_message(log), LOG), Log)
    assert (free.file, str(tmp_path) in free.msg) == ("node.py", False)
    value = ParameterValue(type=4, string_value=str(tmp_path))
    event = ParameterEvent(new_parameters=[Parameter(name="state_dir", value=value)])
    free = deserialize_message(host_free_bytes(serialize_message(event), PARAMETER_EVENT), ParameterEvent)
    assert free.new_parameters[0].value.string_value == tmp_path.name
