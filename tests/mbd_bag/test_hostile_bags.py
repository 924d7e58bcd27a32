"""Whatever a bag holds, reading it ends in bounded time and memory, in its messages or in one sentence."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mbd_bag.errors import BagError
from mbd_bag.formats.bounded_yaml import bounded_yaml
from mbd_bag.formats.record_walk import MAGIC
from mbd_bag.repairing.intact_records import intact_records
from mbd_bag.repairing.mutations import MUTATIONS
from mbd_bag.repairing.reading_trials import ReadingEnd, contents_of, reading_trial, reading_trials
from mbd_bag.repairing.trials import mcap_trials
from mbd_bag.replay.replay_plan import published_topics
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import MessageWriter
from mbd_bag.tools import repair
from mbd_msgs.msg import SessionState, WizardNote
from mbd_study.tables import info
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter

SAMPLE = Path(__file__).resolve().parents[2] / "bags" / "stacking"


@pytest.fixture(scope="module")
def small_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Notes in several chunks, and a state of a session."""
    folder = tmp_path_factory.mktemp("small") / "bag"
    with BagWriter(folder) as bag:
        bag.add_facts({"session": "small"})
        writer = MessageWriter(bag)
        writer.write("/interaction/state", SessionState(session="small", phase=1), 1)
        for k in range(60):
            writer.write("/wizard/note", WizardNote(text=f"note {k} {'x' * k}"), 2 + k)
            if k % 7 == 6:
                bag.flush()
    return folder


def test_a_bag_changed_by_accident_or_malice_is_read_as_before_or_told_of(small_bag: Path, tmp_path: Path):
    trials = list(reading_trials(small_bag, 5 * len(MUTATIONS), 1, tmp_path))
    bad = [t for t in trials if t.end not in (ReadingEnd.REFUSED, ReadingEnd.SAID, ReadingEnd.AS_BEFORE)]
    assert not bad, bad[0].words
    assert max(t.seconds for t in trials) < 10.0
    assert max(t.megabytes for t in trials) < 512.0
    assert {t.end for t in trials} == {ReadingEnd.REFUSED, ReadingEnd.SAID, ReadingEnd.AS_BEFORE}


CASES = {
    "metadata_custom_data_list": "customlist",
    "metadata_deep_nesting": "deepnest",
    "schema_not_utf8": "f129",
    "huge_array": "hugearr2",
}


@pytest.mark.parametrize("case", CASES)
def test_a_bag_once_answered_badly_is_answered_in_one_sentence(case: str, shared_data: Path, tmp_path: Path):
    source = shared_data / "cases" / "bags" / case / CASES[case]
    folder = tmp_path / CASES[case]
    folder.mkdir()
    for file in source.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    if case.startswith("metadata"):  # to stand beside any sample bag's file
        (folder / f"{folder.name}_0.mcap").write_bytes(next(SAMPLE.glob("*.mcap")).read_bytes())
    trial = reading_trial(folder, contents_of(Bag(SAMPLE)), case)
    # The last of them in its index only: its messages are read by the declarations in its chunks, and that is said.
    if case == "schema_not_utf8":
        assert (trial.end, "damaged in its index" in trial.words) == (ReadingEnd.SAID, True), trial.words
    else:
        assert trial.end is ReadingEnd.REFUSED, trial.words
    assert trial.seconds < 10.0
    assert trial.megabytes < 512.0


ALIASES = "\n".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}' if k else 'x'] * 9)}]" for k in range(12))


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, "- " * 100_000, "{a: " * 9000, "9" * 6000, "2020-99-99", "a: &x [*x]", "*x", "a: [", "\0", ALIASES],
)
def test_yaml_that_asks_for_more_than_there_is_is_refused(text: str):
    with pytest.raises(ValueError, match=r"."):
        bounded_yaml(text)


def test_what_is_no_record_is_searched_once_however_much_it_is():
    data = MAGIC + np.random.default_rng(0).bytes(2_000_000)
    begun = time.process_time()
    found = intact_records(memoryview(data))
    # 0.02 s; minutes when the rest of the file is looked at from each of its bytes.
    assert time.process_time() - begun < 10.0
    assert (found.damaged, found.loose) == (2_000_000, [])


def test_repair_keeps_what_is_intact_and_invents_nothing(tmp_path: Path):
    trials = list(mcap_trials([SAMPLE], 4, 3, tmp_path))
    intact = sum(t.intact for t in trials)
    assert intact > 1000
    assert sum(t.kept for t in trials) >= 0.999 * intact
    assert not any(t.invented or t.failure for t in trials)
    assert all(t.noticed for t in trials)


def test_a_bag_with_a_flipped_byte_in_a_chunk_is_no_complete_one(small_bag: Path, tmp_path: Path):
    folder = tmp_path / "bag"
    folder.mkdir()
    for file in small_bag.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    third = Bag(folder).files[0].contents.chunks[2]
    data = bytearray((folder / "bag_0.mcap").read_bytes())
    data[third.chunk_start_offset + third.chunk_length // 2] ^= 0x40
    (folder / "bag_0.mcap").write_bytes(data)
    assert any("damaged" in problem for problem in repair.problems_of(folder))
    repair.repair(folder, tmp_path / "copy")
    kept = [msg.text.split()[1] for _, msg in Bag(tmp_path / "copy").decoded({"/wizard/note"})]
    assert kept == [str(k) for k in range(60) if k // 7 != 2]


def rewritten(source: Path, folder: Path, plugin: StoragePlugin, mode: CompressionMode) -> Path:
    """A bag as another program writes it: without our facts."""
    bag = Bag(source)
    writer = RosbagsWriter(folder, version=9, storage_plugin=plugin)
    if mode is not CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = {
            t.name: writer.add_connection(t.name, t.msgtype, typestore=bag.decoder.store(t.msgtype)) for t in bag.topics
        }
        for message in bag.messages():
            writer.write(connections[message.topic], message.log_time, message.data)
    return folder


@pytest.mark.parametrize("stated", [True, False], ids=["metadata", "no metadata"])
@pytest.mark.parametrize("mode", [CompressionMode.NONE, CompressionMode.FILE, CompressionMode.MESSAGE])
@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_a_bag_is_read_alike_however_rosbag2_stores_it(
    plugin: StoragePlugin, mode: CompressionMode, stated: bool, small_bag: Path, tmp_path: Path
):
    folder = rewritten(small_bag, tmp_path / "bag", plugin, mode)
    if not stated:
        if mode is CompressionMode.MESSAGE:
            pytest.skip("only metadata.yaml states that messages are compressed")
        (folder / "metadata.yaml").unlink()
    assert contents_of(Bag(folder)) == contents_of(Bag(small_bag))
    assert [m.text for _, m in Bag(folder).decoded({"/wizard/note"})][-1].startswith("note 59")


def test_info_states_no_fingerprint_of_what_it_does_not_know(
    small_bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    folder = rewritten(small_bag, tmp_path / "bag", StoragePlugin.SQLITE3, CompressionMode.NONE)
    monkeypatch.setattr(sys, "argv", ["info", str(folder)])
    with pytest.raises(SystemExit) as ended:
        info.main()
    assert ended.value.code == 0
    output = " ".join(capsys.readouterr().out.split())
    assert "61 messages" in output
    assert "unknown: the bag states no versions" in output


def test_several_sqlite_files_are_one_bag(small_bag: Path, tmp_path: Path):
    one = rewritten(small_bag, tmp_path / "bag", StoragePlugin.SQLITE3, CompressionMode.NONE)
    (one / "metadata.yaml").unlink()
    (one / "bag.db3").rename(one / "bag_0.db3")
    (one / "bag_1.db3").write_bytes((one / "bag_0.db3").read_bytes())
    assert Bag(one).message_count == 2 * Bag(small_bag).message_count


def test_events_of_services_are_passed_over_by_name(small_bag: Path, tmp_path: Path):
    known = Bag(small_bag)
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(TopicRecord("/s/_service_event", "std_srvs/srv/Trigger_Event"), "")
        writer.add_topic(
            TopicRecord("/wizard/note", "mbd_msgs/msg/WizardNote"), known.decoder.texts["mbd_msgs/msg/WizardNote"]
        )
        for message in known.messages({"/wizard/note"}):
            writer.write("/wizard/note", message.log_time, message.data)
            writer.write("/s/_service_event", message.log_time, b"\0\1\0\0\1\0\0\0\0")
    bag = Bag(tmp_path / "bag")
    assert bag.check() == ()
    assert [t.name for t in published_topics(bag)] == ["/wizard/note"]


def test_a_message_that_is_not_what_its_definition_says_is_named(small_bag: Path):
    bag = Bag(small_bag)
    message = next(bag.messages({"/wizard/note"}))
    for data in (b"", message.data[:3], message.data[:9], b"\xff" * 40):
        with pytest.raises(BagError, match="/wizard/note"):
            bag.decoder.decode(type(message)(message.topic, message.msgtype, 0, 0, data))
