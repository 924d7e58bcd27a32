"""The launch file's arguments make a session or a reason, and where ROS's launch is installed its actions are right."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from mbd_bringup.launch_arguments import ARGUMENTS, options_of
from mbd_bringup.nodes import STRATEGIES, SessionOptions, session_nodes
from mbd_mapping import inference
from mbd_model.errors import MbdError

FILE = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_bringup" / "launch" / "session.launch.py"


def words(**given: str) -> dict[str, str]:
    """The launch file's arguments, those not given at their defaults."""
    return {name: a.default for name, a in ARGUMENTS.items()} | given


def test_the_defaults_are_a_simulated_session_in_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    expected = SessionOptions("session", tmp_path / "sessions" / "session", markers=True, grasp="friction")
    assert options_of(words()) == expected


def test_every_argument_reaches_the_session(tmp_path):
    given = words(
        session="p07", folder=str(tmp_path), task="assembly", seed="4", strategy="evidence", threshold="0.5",
        simulated="False", speed="0", participant="07", execute="true", scripted_wizard="false", console="true",
        markers="false", grasp="weld",
    )  # fmt: skip
    assert set(given) == set(ARGUMENTS)
    assert options_of(given) == SessionOptions(
        "p07",
        tmp_path / "p07",
        "assembly",
        4,
        "evidence",
        0.5,
        False,
        0.0,
        "07",
        True,
        False,
        True,
        False,
        grasp="weld",
    )


@pytest.mark.parametrize(
    ("name", "word", "why"),
    [
        ("seed", "three", "seed:=three is not an integer"),
        ("seed", "-1", "seed -1 is not in 0..2147483647"),
        ("speed", "fast", "speed:=fast is not a number"),
        ("speed", "nan", "speed nan is not in 0..1000"),
        ("threshold", "2", "threshold 2 is not in 0..1"),
        ("threshold", "nan", "threshold nan is not in 0..1"),
        ("strategy", "best", "strategy 'best' is none of mbd, evidence"),
        ("grasp", "glue", "grasp 'glue' is none of weld, friction"),
        ("execute", "maybe", "execute:=maybe is neither true nor false"),
        ("session", "a/b", "nor hold a slash"),
    ],
)
def test_a_word_that_cannot_be_used_is_named_before_any_node_is_started(name, word, why):
    with pytest.raises(MbdError) as refused:
        options_of(words(**{name: word}))
    assert why in str(refused.value)


def test_a_session_that_is_there_is_gone_on_with_only_when_asked(tmp_path):
    bag = tmp_path / "p07" / "bag"
    bag.mkdir(parents=True)
    assert options_of(words(session="p07", folder=str(tmp_path))).bag == bag
    (bag / "metadata.yaml").touch()
    with pytest.raises(MbdError, match=r"holds a session already.*give another session:=.*resume:=true"):
        options_of(words(session="p07", folder=str(tmp_path)))
    assert options_of(words(session="p07", folder=str(tmp_path), resume="true")).resume


def test_the_strategies_to_choose_from_are_those_of_the_mapping():
    assert set(STRATEGIES) == set(inference.STRATEGIES)


def test_the_launch_file_starts_every_node_of_the_session_and_keeps_words_words(tmp_path):
    pytest.importorskip("launch_ros", reason="launch is not on PyPI: this needs a normal ROS 2 install")
    from launch import LaunchContext
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    from launch_ros.actions import Node

    spec = importlib.util.spec_from_file_location("session_launch", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    entities = module.generate_launch_description().entities
    declared = [e for e in entities if isinstance(e, DeclareLaunchArgument)]
    assert [d.name for d in declared] == list(ARGUMENTS)
    given = words(folder=str(tmp_path), session="07", participant="07", execute="true", console="true")
    context = LaunchContext()
    context.launch_configurations.update(given)
    opaque = next(e for e in entities if isinstance(e, OpaqueFunction))
    nodes = opaque.execute(context)
    assert all(isinstance(n, Node) for n in nodes)
    assert [(n.node_package, n.node_executable) for n in nodes] == [
        (s.package, s.executable) for s in session_nodes(options_of(given))
    ]
    # A name of digits stays a name; what is no text stays what it is.
    assert module.typed("07").evaluate(context) == "07"
    assert module.typed(False) is False
