"""A table of parameters takes what it states it takes, and states what was meant by what it refuses."""

from __future__ import annotations

import math
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import assume, given
from hypothesis import strategies as st
from mbd_model.parameters import (
    ParameterError,
    ParameterSpec,
    ParameterTable,
    ParameterTypeError,
    nearest,
)

TABLE = ParameterTable(
    "arm",
    (
        ParameterSpec("port", 8080, "Where to listen.", range=(1, 65535)),
        ParameterSpec("patience", 3.0, "How long to wait.", "s", range=(0.1, 60.0)),
        ParameterSpec("place", (0.0, 1.0, 2.0), "Where it stands.", "m"),
        ParameterSpec("joints", ("a", "b"), "What moves."),
        ParameterSpec("mode", "slow", "How it moves.", choices=("slow", "fast"), formerly=("manner",)),
        ParameterSpec("level", math.nan, "NaN: learn it."),
        ParameterSpec("keep", True, "Whether to keep it."),
        ParameterSpec(
            "limit", 1.0, "Twice as much when it is fast.", derived=lambda v: 2.0 if v["mode"] == "fast" else 1.0
        ),
    ),
)
finite = st.floats(allow_nan=False, allow_infinity=False, width=32)
values = st.fixed_dictionaries(
    {},
    optional={
        "port": st.integers(1, 65535),
        "patience": st.floats(0.1, 60.0),
        "place": st.tuples(finite, finite, finite),
        "joints": st.lists(st.text(max_size=8), max_size=4).map(tuple),
        "mode": st.sampled_from(["slow", "fast"]),
        "level": finite,
        "keep": st.booleans(),
    },
)
# What a slip of the finger makes of a word: two letters exchanged, one lost, one twice.
slips = st.sampled_from(
    [
        lambda word, i: word[:i] + word[i + 1 : i + 2] + word[i : i + 1] + word[i + 2 :],
        lambda word, i: word[:i] + word[i + 1 :],
        lambda word, i: word[: i + 1] + word[i:],
    ]
)


@given(values)
def test_what_is_not_given_has_its_default(given_values: dict[str, Any]):
    made = TABLE.values(given_values)
    assert tuple(made) == TABLE.names
    assert {name: made[name] for name in given_values} == given_values
    for name in set(TABLE.names) - set(given_values) - {"limit", "level"}:
        assert made[name] == TABLE[name].default
    assert made["limit"] == (2.0 if made["mode"] == "fast" else 1.0)


@given(values)
def test_values_come_back_from_a_file_and_from_a_record(given_values: dict[str, Any]):
    plain = yaml.safe_load(yaml.safe_dump({n: list(v) if isinstance(v, tuple) else v for n, v in given_values.items()}))
    assert TABLE.recorded({**plain, "use_sim_time": True, "of_another_version": 3}) == given_values


@given(st.sampled_from(TABLE.names), slips, st.integers(0, 20))
def test_a_misspelt_name_is_refused_with_the_nearest_right_one(name: str, slip: Any, at: int):
    wrong = slip(name, at % len(name))
    assume(wrong not in TABLE.names)
    with pytest.raises(ParameterError, match=rf"arm has no parameter '{wrong}'; did you mean '(\w+)'\?") as refused:
        TABLE.values({wrong: 1})
    meant = str(refused.value).rpartition("did you mean '")[2].removesuffix("'?")
    alike = [SequenceMatcher(None, right, wrong).ratio() for right in (meant, name)]
    assert alike[0] >= alike[1]


def test_a_name_like_none_is_refused_with_all_there_are():
    with pytest.raises(ParameterError, match=r"no parameter 'xyz'; it has: port, patience, place"):
        TABLE.refuse_unknown(["xyz"])
    assert nearest("xyz", TABLE.names) == ""


def test_every_misspelt_name_is_named_at_once():
    with pytest.raises(ParameterError, match=r"'prot'.*'port'.*; .*'moed'.*'mode'"):
        TABLE.refuse_unknown(["prot", "keep", "moed"])


def test_a_name_of_an_earlier_version_is_read_from_a_record_and_refused_from_a_person_with_the_new_one():
    assert TABLE.recorded({"manner": "fast"}) == {"mode": "fast"}
    assert TABLE.recorded({"manner": "fast", "mode": "slow"}) == {"mode": "slow"}
    with pytest.raises(ParameterError, match=r"'manner' of arm is called 'mode' now"):
        TABLE.values({"manner": "fast"})


def test_ros_s_own_names_are_never_refused():
    TABLE.refuse_unknown(["use_sim_time", "start_type_description_service", "qos_overrides./clock.subscription.depth"])


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("port", 0, r"port is 0; expected integer, 1 to 65535"),
        ("patience", 61.0, r"patience is 61.0; expected number, 0.1 to 60 \[s\]"),
        ("patience", math.nan, r"patience is nan; expected finite"),
        ("place", (0.0, math.inf, 0.0), r"place is \[0.0, inf, 0.0\]; expected finite"),
        ("level", math.inf, r"level is inf; expected finite"),
        ("mode", "quick", r"mode is 'quick'; expected one of: slow, fast"),
    ],
)
def test_a_value_that_is_not_allowed_is_refused_with_what_is(name: str, value: Any, why: str):
    with pytest.raises(ParameterError, match=why) as refused:
        TABLE.values({name: value})
    assert not isinstance(refused.value, ParameterTypeError)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("port", 80.0),
        ("port", True),
        ("patience", "3"),
        ("patience", True),
        ("place", (0.0, 1.0)),
        ("place", "abc"),
        ("place", (0.0, 1.0, True)),
        ("joints", "ab"),
        ("joints", ("a", 1)),
        ("mode", 1),
        ("keep", 1),
        ("keep", "true"),
    ],
)
def test_a_value_of_another_type_is_refused_with_the_type(name: str, value: Any):
    with pytest.raises(ParameterTypeError, match=f"parameter {name} is .*; expected {TABLE[name].kind}"):
        TABLE.values({name: value})


def test_an_integer_will_do_for_a_number_and_nan_where_it_is_the_default():
    made = TABLE.values({"patience": 3, "place": [0, 1, 2], "level": math.nan})
    assert [type(v) for v in (made["patience"], *made["place"])] == [float] * 4
    assert math.isnan(made["level"])


def test_a_parameter_file_gives_each_node_its_own_sections(tmp_path: Path):
    file = tmp_path / "arm.yaml"
    file.write_text(
        "/**:\n  ros__parameters: {port: 1, use_sim_time: true}\n"
        "/**/arm:\n  ros__parameters: {port: 2}\n"
        "/leg:\n  ros__parameters: {knees: 1}\n"
    )
    assert TABLE.in_file(file) == {"port": 2}


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("/**:\n  ros__parameters: {prot: 1}\n", r"arm\.yaml: arm has no parameter 'prot'; did you mean 'port'\?"),
        ("/**:\n  ros__parameters: {port: 0}\n", r"arm\.yaml: parameter port is 0"),
        ("/**:\n  port: 1\n", r"arm\.yaml is no ROS parameter file"),
        ("[1, 2]", r"arm\.yaml is no ROS parameter file"),
        ("{", r"arm\.yaml is no ROS parameter file"),
        ("", r"arm\.yaml is no ROS parameter file; expected sections"),
        ("/**: 3", r"has no ros__parameters"),
    ],
)
def test_a_parameter_file_of_no_use_is_named_with_the_reason(tmp_path: Path, text: str, why: str):
    file = tmp_path / "arm.yaml"
    file.write_text(text)
    with pytest.raises(ParameterError, match=why):
        TABLE.in_file(file)
    with pytest.raises(ParameterError, match=r"nowhere\.yaml cannot be read"):
        TABLE.in_file(tmp_path / "nowhere.yaml")
