"""The recorder asks for what every publisher can serve, and log times never go back."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.recorder.log_clock import LogClock
from mbd_bag.ros.qos_profiles import offered_profile
from mbd_bag.session.session_facts import as_text, parameter_facts, parameters_of
from mbd_bag.storage.topic_qos import LARGEST_DEPTH, TopicQos, as_yaml, from_yaml, wanted_qos

profiles = st.builds(
    TopicQos,
    reliability=st.sampled_from(["reliable", "best_effort"]),
    durability=st.sampled_from(["transient_local", "volatile"]),
    history=st.sampled_from(["keep_last", "keep_all"]),
    depth=st.integers(0, 1000),
)
scalars = st.one_of(
    st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), st.text(st.characters(codec="utf-8"))
)


@given(st.lists(profiles, min_size=1))
def test_every_publisher_can_serve_what_is_wanted(publishers: list[TopicQos]):
    wanted = wanted_qos(publishers, ())
    for offered in publishers:
        assert wanted.reliability == "best_effort" or offered.reliability == "reliable"
        assert wanted.durability == "volatile" or offered.durability == "transient_local"


@given(st.lists(profiles, min_size=1))
def test_the_publishers_decide_as_soon_as_there_is_one(listeners: list[TopicQos]):
    latched = TopicQos("reliable", "transient_local", "keep_last", 1)
    assert wanted_qos([latched], listeners).durability == "transient_local"
    assert wanted_qos((), [latched]).durability == "transient_local"


@given(st.lists(profiles, max_size=3))
def test_profiles_are_read_as_they_were_written(offered: list[TopicQos]):
    assert from_yaml(as_yaml(offered)) == tuple(offered)


@pytest.mark.parametrize("text", ["", "[", "- 1", "- {history: 1}"])
def test_profiles_of_another_program_are_none(text: str):
    assert from_yaml(text) == ()


def test_policies_that_earlier_rosbag2_wrote_as_numbers_are_the_same_as_by_name():
    first = "- {history: 1, depth: 7, reliability: 2, durability: 1}\n"
    second = "- {history: 3, depth: -1, reliability: 0, durability: 9}\n"
    assert from_yaml(first + second) == (
        TopicQos("best_effort", "transient_local", "keep_last", 7),
        TopicQos("reliable", "volatile", "unknown", 0),
    )


@given(st.text(), st.text(), st.text(), st.integers())
def test_whatever_a_bag_states_a_replay_can_offer(reliability: str, durability: str, history: str, depth: int):
    stated = [{"reliability": reliability, "durability": durability, "history": history, "depth": depth}]
    for profile in from_yaml(yaml.safe_dump(stated)):
        assert 0 <= offered_profile(profile).depth <= LARGEST_DEPTH


@given(st.lists(st.integers(0, 10**12)), st.integers(0, 10**12))
def test_log_times_never_go_back_and_follow_a_clock_that_goes_on(times: list[int], latest: int):
    clock = LogClock(latest)
    stamps = [clock.stamp(t) for t in times]
    assert stamps == sorted(stamps)
    assert all(stamp >= time for stamp, time in zip(stamps, times, strict=True))
    assert clock.stamp(2 * 10**12) == 2 * 10**12


@given(st.dictionaries(st.from_regex(r"[a-z_]+(\.[a-z_]+)?", fullmatch=True), st.one_of(scalars, st.lists(scalars))))
def test_parameters_are_read_from_the_facts_as_they_were(values: dict[str, object]):
    facts = parameter_facts("/lab/mapping", values) | parameter_facts("/other", {"sigma": 1})
    assert parameters_of(facts, "mapping") == values


def test_a_text_that_looks_like_a_number_stays_a_text():
    assert as_text("0.10") != as_text(0.10)
    assert as_text(0.02) == "0.02"
