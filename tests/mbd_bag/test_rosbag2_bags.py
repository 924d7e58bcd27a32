"""rosbag2's own test bags are read, or refused in one sentence, by every tool that takes a bag.

rosbag2_bags.tar.xz has them as they lie in github.com/ros2/rosbag2, commit 25304dd (Apache License 2.0).
"""

from __future__ import annotations

import importlib
import sys
import tarfile
from pathlib import Path

import pytest
from mbd_bag.errors import BagError
from mbd_bag.storage.bag import Bag

MCAP, SQLITE = "resources/mcap", "resources/sqlite3"
# Messages in each, as its metadata.yaml or rosbag2's test of it states.
COUNTS = {
    "rosbag2_cpp/test/rosbag2_cpp/bags/only_services.mcap": 12,
    "rosbag2_cpp/test/rosbag2_cpp/bags/only_topics.mcap": 7,
    "rosbag2_cpp/test/rosbag2_cpp/bags/topics_and_services.db3": 13,
    "rosbag2_cpp/test/rosbag2_cpp/bags/topics_and_services.mcap": 13,
    "rosbag2_py/test/resources/mcap/reindex_test_bags/multiple_files": 3177,
    "rosbag2_py/test/resources/sqlite3/reindex_test_bags/multiple_files": 3177,
} | {
    f"{package}/{kind}/{name}": count
    for kind in (MCAP, SQLITE)
    for package, name, count in (
        ("rosbag2_py/test", "convert_a", 150),
        ("rosbag2_py/test", "convert_b", 75),
        ("rosbag2_py/test", "talker", 20),
        ("rosbag2_py/test", "wbag", 6074),
        ("rosbag2_tests", "bag_with_topics_and_service_events", 10),
        ("rosbag2_tests", "cdr_test", 7),
        ("rosbag2_tests", "wrong_rmw_test", 7),
        ("rosbag2_transport/test", "rewriter_a", 150),
        ("rosbag2_transport/test", "rewriter_b", 75),
        ("rosbag2_transport/test", "test_bag_for_seek", 5),
    )
}
TOOLS = {
    "mbd_study.tables.info": "",
    "mbd_study.tables.session_table": "",
    "mbd_study.figures.pictures": "--out {out}/picture.png",
    "mbd_study.figures.report": "--out {out}/report.html",
    "mbd_study.recompute.reevaluate_command": "--jobs 1",
    "mbd_study.recompute.replay_command": "--check",
    "mbd_study.tables.export": "--out {out}/tables --jobs 1",
    "mbd_study.bids.bids_command": "--out {out}/bids --jobs 1",
    "mbd_study.sharing.share_command": "--out {out}/shared",
    "mbd_experiments.user_study.answers": "",
    "mbd_experiments.user_study.lab_prior_command": "--out {out}/prior",
}


@pytest.fixture(scope="module")
def rosbag2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rosbag2")
    with tarfile.open(Path(__file__).with_name("rosbag2_bags.tar.xz")) as packed:
        packed.extractall(folder, filter="data")
    return folder


def test_every_message_of_every_bag_is_read(rosbag2: Path):
    for name, count in COUNTS.items():
        bag = Bag(rosbag2 / name)
        assert sum(1 for _ in bag.messages()) == bag.message_count == count, name
        said = [p for p in bag.check() if "no definition" not in p and "no metadata.yaml" not in p]
        assert said == [], name


def test_text_is_what_was_published(rosbag2: Path):
    for kind in (MCAP, SQLITE):
        bag = Bag(rosbag2 / "rosbag2_py/test" / kind / "talker")
        texts = [message.data for _, message in bag.decoded({"/topic"})]
        assert texts == [f"Hello, world! {k}" for k in range(10)]


def test_a_type_named_as_before_dashing_is_known(rosbag2: Path):
    bag = Bag(rosbag2 / "rosbag2_transport/test" / MCAP / "test_bag_for_seek")
    assert [topic.msgtype for topic in bag.topics] == ["test_msgs/BasicTypes"]
    assert len([message.int32_value for _, message in bag.decoded()]) == 5


def test_what_is_serialized_otherwise_than_ros_does_is_not_taken_for_it(rosbag2: Path):
    with pytest.raises(BagError, match="wrong_format"):
        list(Bag(rosbag2 / "rosbag2_tests" / MCAP / "wrong_rmw_test").decoded())


def test_a_bag_without_a_message_is_refused(rosbag2: Path):
    with pytest.raises(BagError, match="holds no message"):
        Bag(rosbag2 / "ros2bag/test/resources/empty_bag")


@pytest.mark.parametrize("tool", TOOLS, ids=lambda tool: tool.rpartition(".")[2])
def test_every_tool_refuses_them_as_sessions_in_one_sentence(
    tool: str, rosbag2: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    main = importlib.import_module(tool).main
    for name in (*COUNTS, "ros2bag/test/resources/empty_bag"):
        monkeypatch.setattr(sys, "argv", ["tool", str(rosbag2 / name), *TOOLS[tool].format(out=tmp_path).split()])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        words = " ".join((said.out + said.err).split())
        assert ended.value.code == 2, (name, words)
        assert "another program" in words or "holds no message" in words, (name, words)


def test_repair_says_that_they_are_complete_or_copies_every_message(
    rosbag2: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    main = importlib.import_module("mbd_bag.tools.repair").main
    for name in COUNTS:
        out = tmp_path / name.replace("/", "_")
        monkeypatch.setattr(sys, "argv", ["repair", str(rosbag2 / name), "--out", str(out)])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        words = " ".join((said.out + said.err).split())
        # Of the others, nothing is missing; these two have no metadata.yaml.
        expected = "3177 messages" if name.endswith("reindex_test_bags/multiple_files") else "is complete"
        assert (ended.value.code, expected in words) == (0, True), (name, words)
