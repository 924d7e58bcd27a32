"""A bag that is cut off is read as far as it goes; one that is none states what is wrong; none is ever overwritten."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter, Compression
from mbd_bag.storage.mcap_completion import complete
from mbd_bag.storage.mcap_file import McapFile
from mbd_study.figures import pictures
from mbd_study.recompute import reevaluate_command as reevaluate
from mbd_study.recompute import replay_command as replay
from mbd_study.tables import info, session_table
from mcap.writer import Writer as McapWriter
from noted_bags import cut_to, texts, write_notes
from rosbags.rosbag2 import Reader, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


@pytest.fixture(scope="module")
def intact(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished file."""
    folder = tmp_path_factory.mktemp("intact") / "bag"
    write_notes(folder, 12)
    return folder / "bag_0.mcap"


@given(share=st.floats(0.0, 1.0))
def test_a_file_cut_anywhere_gives_the_messages_before_the_cut_or_states_why_not(
    share: float, intact: Path, tmp_path_factory: pytest.TempPathFactory
):
    folder = tmp_path_factory.mktemp("cut") / "bag"
    folder.mkdir()
    file = folder / "bag_0.mcap"
    file.write_bytes(intact.read_bytes()[: int(share * intact.stat().st_size)])
    try:
        read = texts(folder)
    except BagError as error:
        assert "empty" in str(error) or "cut off" in str(error) or "no message" in str(error) or "MCAP" in str(error)
        return
    assert read == [f"note {k}" for k in range(len(read))]
    assert len(read) % 3 == 0
    assert len(read) == 12 or Bag(folder).problems
    complete(file)
    assert texts(folder) == read
    with Reader(file) as reader:
        assert reader.message_count == 2 * len(read) == len(list(reader.messages()))


@example(offset=135, bit=0, lost=0)  # a chunk of 2**40 bytes
@given(offset=st.integers(9, 20_000), bit=st.integers(0, 7), lost=st.sampled_from([0, 40]))
def test_a_flipped_bit_in_a_complete_or_cut_file_is_noticed_or_harmless(
    offset: int, bit: int, lost: int, intact: Path, tmp_path_factory: pytest.TempPathFactory
):
    data = bytearray(intact.read_bytes())
    del data[len(data) - lost :]
    data[offset % len(data)] ^= 1 << bit
    file = tmp_path_factory.mktemp("flip") / "bag_0.mcap"
    file.write_bytes(data)
    try:
        read = [x.log_time for x in McapFile(file).messages({"/wizard/note"})]
    except BagError:
        return
    assert read == list(range(len(read)))


def test_a_bag_that_exists_is_never_overwritten(tmp_path: Path):
    write_notes(tmp_path / "bag", 3)
    before = {p: p.read_bytes() for p in (tmp_path / "bag").iterdir()}
    with pytest.raises(BagError, match="exists already"):
        BagWriter(tmp_path / "bag")
    assert {p: p.read_bytes() for p in (tmp_path / "bag").iterdir()} == before


def test_a_folder_of_other_things_is_not_written_into(tmp_path: Path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(BagError, match="other files"):
        BagWriter(tmp_path)
    with pytest.raises(BagError, match="is a file"):
        BagWriter(tmp_path / "notes.txt")


def test_a_bag_being_written_is_not_taken_over(tmp_path: Path):
    first = BagWriter(tmp_path / "bag")
    with pytest.raises(BagError, match="another recorder"):
        BagWriter(tmp_path / "bag", resume=True)
    first.close()


def test_a_full_disk_is_noticed_before_recording(tmp_path: Path):
    with pytest.raises(BagError, match="MB are free"):
        BagWriter(tmp_path / "bag", min_free=1 << 60)
    assert not list((tmp_path / "bag").glob("*.mcap"))


@pytest.mark.parametrize("compression", list(Compression))
def test_after_a_dead_recorder_the_next_goes_on_in_the_next_file(compression: Compression, tmp_path: Path):
    folder = tmp_path / "bag"
    write_notes(folder, 6, compression=compression)
    (folder / "metadata.yaml").unlink()
    file = folder / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[:-300])
    write_notes(folder, 6, start=6, compression=compression)
    read = texts(folder)
    assert read[-6:] == [f"note {k}" for k in range(6, 12)]
    with Reader(folder) as reader:
        assert len(reader.storage.files) == 2
        assert reader.message_count == len(list(reader.messages())) == 2 * len(read)
    assert Bag(folder).problems == ()
    assert Bag(folder).facts["session"] == "notes"


def test_a_finished_bag_is_gone_on_with_only_when_asked(tmp_path: Path):
    write_notes(tmp_path / "bag", 3)
    write_notes(tmp_path / "bag", 3, start=3, resume=True)
    assert texts(tmp_path / "bag") == [f"note {k}" for k in range(6)]


def test_an_empty_first_file_of_a_recorder_that_died_at_once_is_passed_over(tmp_path: Path):
    folder = tmp_path / "bag"
    folder.mkdir()
    (folder / "bag_0.mcap").touch()
    write_notes(folder, 3)
    assert texts(folder) == ["note 0", "note 1", "note 2"]


def foreign_profile(folder: Path) -> None:
    folder.mkdir()
    with (folder / "x_0.mcap").open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="", library="another program")
        writer.finish()


def foreign_topics(folder: Path, plugin: StoragePlugin = StoragePlugin.MCAP) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    with RosbagsWriter(folder, version=9, storage_plugin=plugin) as bag:
        connection = bag.add_connection("/chatter", "std_msgs/msg/String", typestore=store)
        text = store.types["std_msgs/msg/String"](data="hello")
        bag.write(connection, 1, store.serialize_cdr(text, "std_msgs/msg/String"))


BAD = {
    "nothing": (lambda p: None, "there is no bag"),
    "text": (lambda p: p.write_text("this is no bag"), "no MCAP file"),
    "folder": (lambda p: p.mkdir(), "no bag"),
    "empty": (lambda p: cut_to(p, 0), "empty"),
    "cut at once": (lambda p: cut_to(p, 12), "cut off"),
    "no message": (lambda p: write_notes(p, 0), "no message"),
    "profile": (foreign_profile, "another program"),
    "topics": (foreign_topics, "another program"),
    "sqlite": (lambda p: foreign_topics(p, StoragePlugin.SQLITE3), "another program"),
    "metadata": (lambda p: (p.mkdir(), (p / "metadata.yaml").write_text("a: [")), "metadata.yaml"),
    "missing file": (lambda p: (write_notes(p, 3), (p / f"{p.name}_0.mcap").unlink()), "missing"),
}


@pytest.mark.parametrize("case", BAD)
@pytest.mark.parametrize("tool", [replay, info, session_table, pictures, reevaluate], ids=lambda t: t.__name__)
def test_every_tool_states_what_is_wrong_with_a_bad_bag_and_exits_with_2(
    tool: object, case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    make, words = BAD[case]
    make(tmp_path / "bad")
    more = ["--out", str(tmp_path / "x.png")] if tool is pictures else []
    monkeypatch.setattr(sys, "argv", ["tool", str(tmp_path / "bad"), *more])
    with pytest.raises(SystemExit) as ended:
        tool.main()
    assert ended.value.code == 2
    output = " ".join(capsys.readouterr().err.split())
    assert words in output
    assert "Traceback" not in output


def foreign_note(folder: Path, msgtype: str, fields: str, **values: object) -> Path:
    """A bag with one message of another definition on ``wizard/note``."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(f"std_msgs/Header header\n{fields}\n", msgtype))
    with RosbagsWriter(folder, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        connection = bag.add_connection("/wizard/note", msgtype, typestore=store)
        time = store.types["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
        header = store.types["std_msgs/msg/Header"](stamp=time, frame_id="")
        bag.write(connection, 1, store.serialize_cdr(store.types[msgtype](header=header, **values), msgtype))
    return folder


@pytest.mark.parametrize(
    ("msgtype", "words"),
    [("mbd_msgs/msg/WizardNote", "'text'.*int32.*string"), ("other_msgs/msg/Note", "expected 'mbd_msgs/msg/W")],
)
def test_a_topic_of_ours_that_cannot_be_read_any_more_is_named(msgtype: str, words: str, tmp_path: Path):
    with pytest.raises(BagError, match=words):
        session_from_bag(Bag(foreign_note(tmp_path / "old", msgtype, "int32 text", text=3)))


def test_a_field_that_an_older_version_lacks_is_read_as_empty_and_reported(tmp_path: Path):
    session = session_from_bag(Bag(foreign_note(tmp_path / "old", "mbd_msgs/msg/WizardNote", "")))
    assert [n.value for n in session.notes] == [""]
    assert session.notes[0].stamp == 1_000_000_000
    assert any("WizardNote.text" in problem for problem in session.problems)


def test_a_renamed_bag_is_still_read(made_bag: Path, tmp_path: Path):
    shutil.copytree(made_bag, tmp_path / "renamed")
    assert Bag(tmp_path / "renamed").message_count == Bag(made_bag).message_count
    (tmp_path / "renamed" / "metadata.yaml").unlink()
    assert Bag(tmp_path / "renamed").message_count == Bag(made_bag).message_count
